/* Third part of fmi3.c: functions that every FMI 3.0 library has, for types and clocks that a friction FMU has not. */

#define REFUSED(name)                                                  \
    if (n == 0) return fmi3OK;                                         \
    return STATUS(vr ? unknown(m, name, vr[0]) : given(m, n, NULL, NULL))

#define NO_VARIABLES(type)                                                                                                 \
    fmi3Status fmi3Get##type(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3##type values[], size_t count) { \
        INSTANCE(c);                                                                                                       \
        (void)values; (void)count;                                                                                         \
        REFUSED(#type);                                                                                                    \
    }                                                                                                                      \
    fmi3Status fmi3Set##type(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3##type values[],           \
                             size_t count) {                                                                               \
        INSTANCE(c);                                                                                                       \
        (void)values; (void)count;                                                                                         \
        REFUSED(#type);                                                                                                    \
    }
NO_VARIABLES(Float32)
NO_VARIABLES(Int8)
NO_VARIABLES(UInt8)
NO_VARIABLES(Int16)
NO_VARIABLES(UInt16)
NO_VARIABLES(Int32)
NO_VARIABLES(UInt32)
NO_VARIABLES(Int64)
NO_VARIABLES(String)

fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, size_t sizes[], fmi3Binary values[], size_t count) {
    INSTANCE(c);
    (void)sizes; (void)values; (void)count;
    REFUSED("Binary");
}

fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const size_t sizes[], const fmi3Binary values[],
                         size_t count) {
    INSTANCE(c);
    (void)sizes; (void)values; (void)count;
    REFUSED("Binary");
}

fmi3Status fmi3GetClock(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Clock values[]) {
    INSTANCE(c);
    (void)values;
    REFUSED("Clock");
}

fmi3Status fmi3SetClock(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Clock values[]) {
    INSTANCE(c);
    (void)values;
    REFUSED("Clock");
}

fmi3Status fmi3GetIntervalDecimal(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 intervals[],
                                  fmi3IntervalQualifier qualifiers[]) {
    INSTANCE(c);
    (void)intervals; (void)qualifiers;
    REFUSED("Clock");
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3UInt64 counters[],
                                   fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[]) {
    INSTANCE(c);
    (void)counters; (void)resolutions; (void)qualifiers;
    REFUSED("Clock");
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 shifts[]) {
    INSTANCE(c);
    (void)shifts;
    REFUSED("Clock");
}

fmi3Status fmi3GetShiftFraction(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3UInt64 counters[],
                                fmi3UInt64 resolutions[]) {
    INSTANCE(c);
    (void)counters; (void)resolutions;
    REFUSED("Clock");
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Float64 intervals[]) {
    INSTANCE(c);
    (void)intervals;
    REFUSED("Clock");
}

fmi3Status fmi3SetIntervalFraction(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3UInt64 counters[],
                                   const fmi3UInt64 resolutions[]) {
    INSTANCE(c);
    (void)counters; (void)resolutions;
    REFUSED("Clock");
}

fmi3Status fmi3SetShiftDecimal(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Float64 shifts[]) {
    INSTANCE(c);
    (void)shifts;
    REFUSED("Clock");
}

fmi3Status fmi3SetShiftFraction(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3UInt64 counters[],
                                const fmi3UInt64 resolutions[]) {
    INSTANCE(c);
    (void)counters; (void)resolutions;
    REFUSED("Clock");
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance c, fmi3ValueReference clock, fmi3Float64 time) {
    INSTANCE(c);
    (void)clock; (void)time;
    return STATUS(tf_fail(m, "scheduled execution is not offered"));
}
