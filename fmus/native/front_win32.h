/* The solver process on Windows.

   Named pipes instead of anonymous ones: only they can be waited for together, with a limit. The process is
   in a job that ends with the last handle to it, which is the host's: it ends with the host, also when the
   host is killed. It inherits the three handles of the list and no other. */

#ifndef WIN32_LEAN_AND_MEAN
#define WIN32_LEAN_AND_MEAN
#endif
#include <windows.h>

typedef struct {
    HANDLE connection, errors, process, job;
    OVERLAPPED moving, listening; /* requests and replies; standard error */
    char heard[1024];
    int is_listening;
    tf_tail tail;
    char ending[64];
} tf_child;

static const char *const tf_interpreters[] = {"python", "python3", "py"};

static double tf_now(void) { return 1e-3 * (double)GetTickCount64(); }

/* Text between UTF-8 and the system's. 0: it does not fit. */
static int tf_widen(const char *text, wchar_t *wide, int size) {
    return MultiByteToWideChar(CP_UTF8, 0, text, -1, wide, size) > 0;
}

static int tf_environment(const char *name, char *value, size_t size) {
    wchar_t wide_name[64], wide[TF_PATH];
    if (!tf_widen(name, wide_name, 64)) return 0;
    const DWORD n = GetEnvironmentVariableW(wide_name, wide, TF_PATH);
    if (n == 0 || n >= TF_PATH) return 0;
    return WideCharToMultiByte(CP_UTF8, 0, wide, -1, value, (int)size, NULL, NULL) > 0;
}

static FILE *tf_open(const char *path) {
    wchar_t wide[TF_PATH];
    return tf_widen(path, wide, TF_PATH) ? _wfopen(wide, L"rb") : NULL;
}

static void tf_close(HANDLE *handle) {
    if (*handle && *handle != INVALID_HANDLE_VALUE) CloseHandle(*handle);
    *handle = NULL;
}

/* A pipe that nobody else can be at the other end of: the name is new, and one client is all it takes. */
static int tf_pipe(const tf_child *p, char kind, DWORD direction, DWORD access, HANDLE *here, HANDLE *there) {
    SECURITY_ATTRIBUTES inherited = {sizeof inherited, NULL, TRUE};
    char text[96];
    wchar_t name[96];
    snprintf(text, sizeof text, "\\\\.\\pipe\\tribofmu-%lu-%llx-%llu-%c", GetCurrentProcessId(),
             (unsigned long long)(size_t)p, (unsigned long long)GetTickCount64(), kind);
    if (!tf_widen(text, name, 96)) return 0;
    *here = CreateNamedPipeW(name, direction | FILE_FLAG_OVERLAPPED | FILE_FLAG_FIRST_PIPE_INSTANCE,
                             PIPE_TYPE_BYTE | PIPE_READMODE_BYTE | PIPE_WAIT | PIPE_REJECT_REMOTE_CLIENTS, 1, 65536,
                             65536, 0, NULL);
    if (*here == INVALID_HANDLE_VALUE) return 0;
    *there = CreateFileW(name, access, 0, &inherited, OPEN_EXISTING, 0, NULL);
    return *there != INVALID_HANDLE_VALUE;
}

/* The environment of the host without what ties Python to an installation. */
static wchar_t *tf_own_environment(void) {
    wchar_t *all = GetEnvironmentStringsW(), *kept = NULL;
    size_t size = 0, k = 0;
    while (all && (all[size] || (size && all[size - 1]))) ++size;
    if (all) kept = (wchar_t *)malloc((size + 2) * sizeof *kept);
    for (size_t i = 0; kept && i < size; i += wcslen(all + i) + 1) {
        if (_wcsnicmp(all + i, L"PYTHONHOME=", 11) == 0) continue;
        memcpy(kept + k, all + i, (wcslen(all + i) + 1) * sizeof *kept);
        k += wcslen(all + i) + 1;
    }
    if (kept) {
        kept[k] = 0;
        kept[k + 1] = 0;
    }
    if (all) FreeEnvironmentStringsW(all);
    return kept;
}

/* The file to run: a path as it is, a name from PATH, never from the folder the host runs in. */
static int tf_find(const char *program, wchar_t *file) {
    wchar_t wide[TF_PATH], *path;
    int found;
    if (!tf_widen(program, wide, TF_PATH)) return 0;
    if (wcspbrk(wide, L"\\/:")) {
        memcpy(file, wide, sizeof wide);
        return GetFileAttributesW(file) != INVALID_FILE_ATTRIBUTES;
    }
    const DWORD n = GetEnvironmentVariableW(L"PATH", NULL, 0);
    path = (wchar_t *)malloc(((size_t)n + 1) * sizeof *path);
    if (!path) return 0;
    found = n && GetEnvironmentVariableW(L"PATH", path, n) &&
            SearchPathW(path, wide, L".exe", TF_PATH, file, NULL);
    free(path);
    return found;
}

static int tf_spawn(tf_child *p, const wchar_t *file, HANDLE theirs[3]) {
    char text[2048];
    wchar_t line[2048], *environment = tf_own_environment();
    STARTUPINFOEXW start;
    PROCESS_INFORMATION made;
    JOBOBJECT_EXTENDED_LIMIT_INFORMATION limits;
    SIZE_T size = 0;
    int good = 0;
    memset(&start, 0, sizeof start);
    memset(&limits, 0, sizeof limits);
    limits.BasicLimitInformation.LimitFlags = JOB_OBJECT_LIMIT_KILL_ON_JOB_CLOSE;
    p->job = CreateJobObjectW(NULL, NULL);
    if (p->job) SetInformationJobObject(p->job, JobObjectExtendedLimitInformation, &limits, sizeof limits);
    /* The code has neither quotes nor backslashes, so that it can stand in quotes. */
    snprintf(text, sizeof text, "python -c \"%s\" handle:%llu", tf_bootstrap, (unsigned long long)(size_t)theirs[0]);
    tf_widen(text, line, 2048);
    start.StartupInfo.cb = sizeof start;
    start.StartupInfo.dwFlags = STARTF_USESTDHANDLES;
    start.StartupInfo.hStdInput = theirs[2];
    start.StartupInfo.hStdOutput = start.StartupInfo.hStdError = theirs[1];
    InitializeProcThreadAttributeList(NULL, 1, 0, &size);
    start.lpAttributeList = (LPPROC_THREAD_ATTRIBUTE_LIST)malloc(size);
    if (start.lpAttributeList && InitializeProcThreadAttributeList(start.lpAttributeList, 1, 0, &size)) {
        good = UpdateProcThreadAttribute(start.lpAttributeList, 0, PROC_THREAD_ATTRIBUTE_HANDLE_LIST, theirs,
                                         3 * sizeof *theirs, NULL, NULL) &&
               CreateProcessW(file, line, NULL, NULL, TRUE,
                              CREATE_NO_WINDOW | CREATE_SUSPENDED | CREATE_NEW_PROCESS_GROUP |
                                  CREATE_UNICODE_ENVIRONMENT | EXTENDED_STARTUPINFO_PRESENT,
                              environment, NULL, &start.StartupInfo, &made);
        DeleteProcThreadAttributeList(start.lpAttributeList);
    }
    free(start.lpAttributeList);
    free(environment);
    if (!good) return 0;
    p->process = made.hProcess;
    if (p->job) AssignProcessToJobObject(p->job, made.hProcess);
    ResumeThread(made.hThread);
    CloseHandle(made.hThread);
    return 1;
}

static void tf_release(tf_child *p) {
    tf_close(&p->process);
    tf_close(&p->job);
    tf_close(&p->moving.hEvent);
    tf_close(&p->listening.hEvent);
}

static int tf_child_start(tf_child *p, const char *program, char *why, size_t size) {
    wchar_t file[TF_PATH];
    HANDLE theirs[3] = {NULL, NULL, NULL};
    SECURITY_ATTRIBUTES inherited = {sizeof inherited, NULL, TRUE};
    int good;
    memset(p, 0, sizeof *p);
    snprintf(why, size, "no such file");
    if (!tf_find(program, file)) return TF_NOT_FOUND;
    p->moving.hEvent = CreateEventW(NULL, TRUE, FALSE, NULL);
    p->listening.hEvent = CreateEventW(NULL, TRUE, FALSE, NULL);
    theirs[2] = CreateFileW(L"NUL", GENERIC_READ, 0, &inherited, OPEN_EXISTING, 0, NULL);
    good = p->moving.hEvent && p->listening.hEvent &&
           tf_pipe(p, 'c', PIPE_ACCESS_DUPLEX, GENERIC_READ | GENERIC_WRITE, &p->connection, &theirs[0]) &&
           tf_pipe(p, 'e', PIPE_ACCESS_INBOUND, GENERIC_WRITE, &p->errors, &theirs[1]) &&
           tf_spawn(p, file, theirs);
    if (!good) snprintf(why, size, "Windows error %lu", GetLastError());
    for (int i = 0; i < 3; ++i) tf_close(&theirs[i]);
    if (good) return TF_STARTED;
    tf_close(&p->connection);
    tf_close(&p->errors);
    tf_release(p);
    return TF_REFUSED;
}

/* Keep what has come from standard error and go on listening. */
static void tf_drain(tf_child *p) {
    for (int k = 0; k < 64 && p->errors; ++k) {
        DWORD n = 0;
        if (!p->is_listening) {
            ResetEvent(p->listening.hEvent);
            p->is_listening = ReadFile(p->errors, p->heard, sizeof p->heard, NULL, &p->listening) ||
                              GetLastError() == ERROR_IO_PENDING;
        }
        if (p->is_listening && GetOverlappedResult(p->errors, &p->listening, &n, FALSE)) {
            tf_tail_add(&p->tail, p->heard, n);
            p->is_listening = 0;
        } else if (p->is_listening && GetLastError() == ERROR_IO_INCOMPLETE) return;
        else if (p->is_listening && GetLastError() == ERROR_OPERATION_ABORTED) {
            p->is_listening = 0; /* the thread that began to listen has ended */
        } else {
            p->is_listening = 0;
            ResetEvent(p->listening.hEvent);
            tf_close(&p->errors);
        }
    }
}

/* Wait for the end of a read or write that was begun; the number of bytes moved. */
static int tf_wait(tf_child *p, double until, DWORD *n) {
    for (;;) {
        HANDLE events[2] = {p->moving.hEvent, p->listening.hEvent};
        const double left = until > 0.0 ? until - tf_now() : 1.0;
        tf_drain(p);
        if (left <= 0.0) {
            CancelIoEx(p->connection, &p->moving);
            GetOverlappedResult(p->connection, &p->moving, n, TRUE);
            return TF_LATE;
        }
        WaitForMultipleObjects(p->errors ? 2 : 1, events, FALSE, left < 1.0 ? 1 + (DWORD)(1e3 * left) : 1000);
        if (GetOverlappedResult(p->connection, &p->moving, n, FALSE)) return *n ? TF_DONE : TF_GONE;
        if (GetLastError() != ERROR_IO_INCOMPLETE) return TF_GONE;
    }
}

static int tf_move(tf_child *p, unsigned char *in, const unsigned char *out, size_t n, double until) {
    while (n) {
        const DWORD count = n < 65536 ? (DWORD)n : 65536;
        DWORD moved = 0;
        int result;
        ResetEvent(p->moving.hEvent);
        if (!(in ? ReadFile(p->connection, in, count, NULL, &p->moving)
                 : WriteFile(p->connection, out, count, NULL, &p->moving)) &&
            GetLastError() != ERROR_IO_PENDING)
            return TF_GONE;
        result = tf_wait(p, until, &moved);
        if (result != TF_DONE) return result;
        if (in) in += moved;
        else out += moved;
        n -= moved;
    }
    return TF_DONE;
}

static int tf_child_send(tf_child *p, const unsigned char *bytes, size_t n, double until) {
    return tf_move(p, NULL, bytes, n, until);
}

static int tf_child_receive(tf_child *p, unsigned char *bytes, size_t n, double until) {
    return tf_move(p, bytes, NULL, n, until);
}

/* End the process: it ends by itself when the connection is closed; after `seconds` it is killed.
   Returns its exit code, or -1. `ending` says how it ended. */
static int tf_child_end(tf_child *p, double seconds) {
    const double until = tf_now() + seconds;
    DWORD code = 0;
    tf_close(&p->connection);
    if (!p->process) return -1;
    while (WaitForSingleObject(p->process, 5) == WAIT_TIMEOUT) {
        tf_drain(p);
        if (tf_now() > until) {
            if (p->job) TerminateJobObject(p->job, 1);
            TerminateProcess(p->process, 1);
            WaitForSingleObject(p->process, 5000);
            break;
        }
    }
    tf_drain(p);
    if (p->errors && p->is_listening) { /* the buffer must outlive the read */
        DWORD n = 0;
        CancelIoEx(p->errors, &p->listening);
        GetOverlappedResult(p->errors, &p->listening, &n, TRUE);
        p->is_listening = 0;
    }
    tf_close(&p->errors);
    GetExitCodeProcess(p->process, &code);
    tf_release(p);
    snprintf(p->ending, sizeof p->ending, "has ended with exit code %lu", code);
    return (int)code;
}
