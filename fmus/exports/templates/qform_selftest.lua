-- Plays the host: hands over fields by the names of the arguments, calls UserFields once a step and point and then FrictionStress
-- in every iteration, and compares the coefficients with those in selftest.txt, which come from ONNX Runtime:
--     lua selftest.lua        (or luajit, or with another file: lua selftest.lua points.txt)
-- prints "ok" and the largest deviation, or what went wrong, and then ends with 1.
local stored, defaults = nil, {}
function set_target_workpiece() end
function parameter(_, default) return default end
function result(name, default) defaults[name] = default return {name = name} end
function store(field, value) stored[field.name] = value end

local script = assert(io.open("qform.lua")):read("*a")
dofile("qform.lua")
local function arguments(name)
  local list = {}
  for word in script:match("\nfunction " .. name .. "%((.-)%)"):gmatch("[%w_]+") do list[#list + 1] = word end
  return list
end
local user, friction = arguments("UserFields"), arguments("FrictionStress")
local unpack = table.unpack or unpack
local function call(f, names, fields)
  local values = {}
  for i, name in ipairs(names) do
    values[i] = fields[name]
    assert(values[i] ~= nil, "the host has no field " .. name)
  end
  return f(unpack(values, 1, #names))
end

local worst, calls, wrong = 0.0, 0, false
local file = assert(io.open(arg and arg[1] or "selftest.txt"))
local points = {}
local function read(n)
  local values = {}
  for i = 1, n do
    local word = file:read("*n")
    if not word then return nil end
    values[i] = word
  end
  return values
end
while true do
  local head = read(2) -- dt, number of points
  if not head then break end
  for k = 1, head[2] do
    local row = read(6) -- T, T_tool, speed, pressure of this iteration; expected mu; 1 at the end of the step
    local point = points[k]
    if not point then
      point = {user = {}, before = {T = row[1], T_tool = row[2], v = 0.0, p = 0.0}}
      for name, value in pairs(defaults) do point.user[name] = value end
      points[k] = point
    end
    if not point.open then -- the step begins: fields of the step before, the length of this one
      local b, fields = point.before, {dt = head[1]}
      fields["@FIELD_T_TOOL@"], fields["@FIELD_T@"] = b.T_tool, b.T
      fields["@FIELD_V@"], fields["@FIELD_P@"] = b.v, b.p
      for name, value in pairs(point.user) do fields["prev_" .. name] = value end
      stored = {}
      call(UserFields, user, fields)
      for name in pairs(defaults) do
        if stored[name] == nil then wrong = true end
        point.user[name] = stored[name]
      end
      point.open = true
    end
    local fields = {}
    fields["@FIELD_T_TOOL@"], fields["@FIELD_T@"] = row[2], row[1]
    fields["@FIELD_V@"], fields["@FIELD_P@"] = row[3], row[4]
    for name, value in pairs(point.user) do fields[name] = value end
    local stress = call(FrictionStress, friction, fields)
    calls = calls + 1
    local off = math.abs(stress - row[5] * math.abs(row[4])) / math.max(math.abs(row[4]), 1e-30)
    if row[4] == 0.0 then off = math.abs(stress) end
    if not (off <= 1e-12) then
      print(string.format("point %d, call %d: %.17g, expected %.17g", k, calls, stress, row[5] * row[4]))
      wrong = true
    end
    worst = math.max(worst, off)
    if row[6] == 1 then
      point.before, point.open = {T = row[1], T_tool = row[2], v = row[3], p = row[4]}, false
    end
  end
end
if wrong or calls == 0 then os.exit(1) end
print(string.format("ok: %d coefficients, largest deviation %.1e", calls, worst))
