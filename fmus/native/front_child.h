/* The solver process as the front sees it; front_posix.h and front_win32.h hold what differs.

   Each instance has a process of its own and no variable is shared: instances may live in different threads.
   The connection and the standard error of the process are watched together, in every wait: a process that
   writes much to its standard error would otherwise stand still, and the host with it. */

#ifndef TF_FRONT_CHILD_H
#define TF_FRONT_CHILD_H

#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TF_DONE = 0, TF_GONE, TF_LATE };          /* results of sending and receiving */
enum { TF_STARTED = 0, TF_NOT_FOUND, TF_REFUSED }; /* results of starting */

/* Bytes of standard error that are kept, longest message (hosts may have small stacks), longest file name. */
enum { TF_TAIL = 16384, TF_TEXT = 4096, TF_PATH = 4096 };

/* What the interpreter runs. It must not fail in any Python, and must not take modules from the folder
   in which the host happens to run. "connection" is the last argument. */
static const char tf_bootstrap[] =
    "import sys\n"
    "sys.path[:] = [p for p in sys.path if p]\n"
    "try:\n"
    "    from fmus.slaves.server import main\n"
    "except ImportError as error:\n"
    "    lacks = getattr(error, 'name', None) or str(error)\n"
    "    sys.stderr.write('the Python environment %s lacks %s; install it: pip install tribofmu; '\n"
    "        'or set TRIBOFMU_PYTHON to an interpreter that has it' % (sys.executable, lacks))\n"
    "    sys.exit(86)\n"
    "main(sys.argv[1])\n";
enum { TF_LACKS_PACKAGE = 86 };

typedef struct {
    char text[TF_TAIL];
    size_t length;
} tf_tail;

/* Keep what the process wrote to its standard error; the oldest half goes when there is no room. */
static void tf_tail_add(tf_tail *tail, const char *bytes, size_t n) {
    if (n >= TF_TAIL / 2) {
        bytes += n - (TF_TAIL / 2 - 1);
        n = TF_TAIL / 2 - 1;
    }
    if (tail->length + n >= TF_TAIL) {
        const size_t kept = TF_TAIL / 2;
        memmove(tail->text, tail->text + tail->length - kept, kept);
        tail->length = kept;
    }
    memcpy(tail->text + tail->length, bytes, n);
    tail->length += n;
    tail->text[tail->length] = '\0';
}

/* The last lines, at most eight, in one: many hosts show only one line of a message. */
static const char *tf_tail_line(tf_tail *tail) {
    char *start = tail->text, *end, *c;
    int lines = 0;
    tail->text[tail->length] = '\0';
    /* A list of a hundred names at the end of Python's report of a crash. */
    end = strstr(tail->text, "\nExtension modules:");
    if (!end) end = tail->text + tail->length;
    while (end > start && (end[-1] == '\n' || end[-1] == '\r' || end[-1] == ' ')) --end;
    *end = '\0';
    if (end - start > TF_TEXT / 2) start = end - TF_TEXT / 2;
    for (c = end; c > start; --c)
        if (c[-1] == '\n' && ++lines == 8) start = c;
    while (*start == '\n' || *start == ' ') ++start;
    for (c = start; *c; ++c) {
        if (*c == '\n') *c = c[1] == '\n' ? ' ' : '|';
        else if ((unsigned char)*c < ' ') *c = ' ';
    }
    return start;
}

#ifdef _WIN32
#include "front_win32.h"
#else
#include "front_posix.h"
#endif

#endif
