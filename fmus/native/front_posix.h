/* The solver process on Linux and macOS.

   A pair of sockets instead of two pipes: sending to a process that has ended must not raise SIGPIPE in the
   host, and a socket can be told so without touching the signals of the host. PR_SET_PDEATHSIG is not used:
   it fires when the THREAD ends that started the process; the process watches its connection instead. */

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#ifdef __APPLE__
#include <crt_externs.h>
#define TF_ENVIRONMENT (*_NSGetEnviron())
#define TF_NO_SIGNAL 0
#else
extern char **environ;
#define TF_ENVIRONMENT environ
#define TF_NO_SIGNAL MSG_NOSIGNAL
#endif

/* Descriptor of the connection in the new process. */
#define TF_CONNECTION "fd:3"

typedef struct {
    int connection, errors; /* -1: closed */
    pid_t pid;
    tf_tail tail;
    char ending[64];
} tf_child;

static const char *const tf_interpreters[] = {"python3", "python"};

static double tf_now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int tf_environment(const char *name, char *value, size_t size) {
    const char *found = getenv(name);
    if (!found || !*found || strlen(found) >= size) return 0;
    memcpy(value, found, strlen(found) + 1);
    return 1;
}

static FILE *tf_open(const char *path) { return fopen(path, "rb"); }

static void tf_close(int *descriptor) {
    if (*descriptor >= 0) close(*descriptor);
    *descriptor = -1;
}

/* Lift a descriptor above those that the new process gets, closed in all programs that the host starts. */
static int tf_lift(int descriptor) {
    const int lifted = descriptor < 0 ? -1 : fcntl(descriptor, F_DUPFD_CLOEXEC, 10);
    if (descriptor >= 0) close(descriptor);
    return lifted;
}

/* Two connected ends each; no other program that is started meanwhile may inherit them, where the system can. */
static int tf_connect(int sockets[2], int pipes[2]) {
    int s[2] = {-1, -1}, p[2] = {-1, -1};
#ifdef __linux__
    const int good = socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, s) == 0 && pipe2(p, O_CLOEXEC) == 0;
#else
    const int good = socketpair(AF_UNIX, SOCK_STREAM, 0, s) == 0 && pipe(p) == 0;
#endif
    for (int i = 0; i < 2; ++i) {
        sockets[i] = tf_lift(s[i]);
        pipes[i] = tf_lift(p[i]);
    }
    if (!good || sockets[0] < 0 || sockets[1] < 0 || pipes[0] < 0 || pipes[1] < 0) return 0;
#ifdef __APPLE__
    const int on = 1;
    setsockopt(sockets[0], SOL_SOCKET, SO_NOSIGPIPE, &on, sizeof on);
#endif
    return fcntl(pipes[0], F_SETFL, O_NONBLOCK) == 0;
}

/* The environment of the host without what ties Python to an installation: a host may have set it for its own. */
static char **tf_own_environment(void) {
    char **all = TF_ENVIRONMENT, **kept;
    size_t n = 0, k = 0;
    while (all && all[n]) ++n;
    kept = (char **)malloc((n + 1) * sizeof *kept);
    for (size_t i = 0; kept && i < n; ++i)
        if (strncmp(all[i], "PYTHONHOME=", 11) != 0 && strncmp(all[i], "__PYVENV_LAUNCHER__=", 20) != 0)
            kept[k++] = all[i];
    if (kept) kept[k] = NULL;
    return kept;
}

static int tf_spawn(pid_t *pid, const char *program, int connection, int errors) {
    char *const arguments[] = {(char *)program, (char *)"-c", (char *)tf_bootstrap, (char *)TF_CONNECTION, NULL};
    char **environment = tf_own_environment();
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    sigset_t none, usual;
    short flags = POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF;
    int error;
    if (!environment) return ENOMEM;
#ifdef __APPLE__
    flags |= POSIX_SPAWN_CLOEXEC_DEFAULT;
#endif
    sigemptyset(&none);
    sigemptyset(&usual);
    sigaddset(&usual, SIGPIPE);
    sigaddset(&usual, SIGINT);
    sigaddset(&usual, SIGTERM);
    sigaddset(&usual, SIGHUP);
    sigaddset(&usual, SIGCHLD);
    posix_spawn_file_actions_init(&actions);
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, flags);
    posix_spawnattr_setpgroup(&attributes, 0); /* an interrupt at the terminal is for the host alone */
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setsigdefault(&attributes, &usual);
    error = posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    if (!error) error = posix_spawn_file_actions_adddup2(&actions, errors, 1);
    if (!error) error = posix_spawn_file_actions_adddup2(&actions, errors, 2);
    if (!error) error = posix_spawn_file_actions_adddup2(&actions, connection, 3);
    if (!error) error = posix_spawnp(pid, program, &actions, &attributes, arguments, environment);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    free(environment);
    return error;
}

static int tf_child_start(tf_child *p, const char *program, char *why, size_t size) {
    int sockets[2], pipes[2], error;
    memset(p, 0, sizeof *p);
    p->pid = -1;
    error = tf_connect(sockets, pipes) ? tf_spawn(&p->pid, program, sockets[1], pipes[1]) : errno ? errno : EMFILE;
    tf_close(&sockets[1]);
    tf_close(&pipes[1]);
    p->connection = sockets[0];
    p->errors = pipes[0];
    if (!error) return TF_STARTED;
    tf_close(&p->connection);
    tf_close(&p->errors);
    p->pid = -1;
    snprintf(why, size, "%s", strerror(error));
    return error == ENOENT ? TF_NOT_FOUND : TF_REFUSED;
}

static void tf_drain(tf_child *p) {
    char bytes[1024];
    for (int k = 0; k < 64 && p->errors >= 0; ++k) { /* a flood must not hold up the replies */
        const ssize_t n = read(p->errors, bytes, sizeof bytes);
        if (n > 0) tf_tail_add(&p->tail, bytes, (size_t)n);
        else if (n == 0) tf_close(&p->errors);
        else if (errno != EINTR) return;
    }
}

/* Wait until the connection is ready. A limit of 0 is none. */
static int tf_wait(tf_child *p, short events, double until) {
    for (;;) {
        struct pollfd watched[2] = {{p->connection, events, 0}, {p->errors, POLLIN, 0}};
        const double left = until > 0.0 ? until - tf_now() : 1.0;
        if (left <= 0.0) return TF_LATE;
        if (poll(watched, 2, left < 1.0 ? 1 + (int)(1e3 * left) : 1000) < 0 && errno != EINTR) return TF_GONE;
        if (watched[1].revents) tf_drain(p);
        if (watched[0].revents) return TF_DONE;
    }
}

static int tf_child_send(tf_child *p, const unsigned char *bytes, size_t n, double until) {
    while (n) {
        const ssize_t sent = send(p->connection, bytes, n, MSG_DONTWAIT | TF_NO_SIGNAL);
        if (sent >= 0) {
            bytes += sent;
            n -= (size_t)sent;
        } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
            const int result = tf_wait(p, POLLOUT, until);
            if (result != TF_DONE) return result;
        } else if (errno != EINTR) return TF_GONE;
    }
    return TF_DONE;
}

static int tf_child_receive(tf_child *p, unsigned char *bytes, size_t n, double until) {
    while (n) {
        const int result = tf_wait(p, POLLIN, until);
        ssize_t got;
        if (result != TF_DONE) return result;
        got = recv(p->connection, bytes, n, MSG_DONTWAIT);
        if (got == 0) return TF_GONE;
        if (got > 0) {
            bytes += got;
            n -= (size_t)got;
        } else if (errno != EINTR && errno != EAGAIN && errno != EWOULDBLOCK) return TF_GONE;
    }
    return TF_DONE;
}

/* End the process: it ends by itself when the connection is closed; after `seconds` it is killed.
   Returns its exit code, or -1. `ending` says how it ended. */
static int tf_child_end(tf_child *p, double seconds) {
    const double until = tf_now() + seconds;
    int status = 0, killed = 0;
    pid_t ended = 0;
    tf_close(&p->connection);
    if (p->pid < 0) return -1;
    for (;;) {
        ended = waitpid(p->pid, &status, WNOHANG);
        if (ended != 0 && !(ended < 0 && errno == EINTR)) break; /* an error: the host has collected it */
        if (tf_now() > until + (killed ? 5.0 : 0.0)) {
            if (killed) break; /* cannot be killed now; the host must not hang */
            kill(-p->pid, SIGKILL);
            kill(p->pid, SIGKILL);
            killed = 1;
        }
        struct pollfd watched = {p->errors, POLLIN, 0};
        poll(&watched, 1, 5);
        tf_drain(p);
    }
    tf_drain(p);
    tf_close(&p->errors);
    p->pid = -1;
    snprintf(p->ending, sizeof p->ending, "has ended");
    if (ended <= 0) return -1;
    if (WIFSIGNALED(status)) snprintf(p->ending, sizeof p->ending, "was ended by signal %d", WTERMSIG(status));
    else snprintf(p->ending, sizeof p->ending, "has ended with exit code %d", WEXITSTATUS(status));
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}
