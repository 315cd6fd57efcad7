/* Stands in for the Python solver process on Windows: checks how it was started, answers as STAND_IN says. */

#include <windows.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int get(HANDLE connection, void *bytes, DWORD n) {
    char *to = (char *)bytes;
    while (n) {
        DWORD got = 0;
        if (!ReadFile(connection, to, n, &got, NULL) || !got) return 0;
        to += got;
        n -= got;
    }
    return 1;
}

static void put(HANDLE connection, const void *bytes, DWORD n) {
    DWORD sent = 0;
    if (!WriteFile(connection, bytes, n, &sent, NULL) || sent != n) exit(5);
}

static void reply(HANDLE connection, const void *content, DWORD n) {
    const DWORD length = n + 1;
    put(connection, &length, 4);
    put(connection, "", 1);
    if (n) put(connection, content, n);
}

int main(int argc, char **argv) {
    static unsigned char bytes[1 << 20];
    static const char hello[] = "TFMU\1\0\0\0" "9.9";
    const char *mode = getenv("STAND_IN");
    double outputs[5] = {1.0, 1.0, 1.0, 1.0, 1.0};
    HANDLE connection;
    DWORD length;
    if (argc != 4 || strcmp(argv[1], "-c") != 0 || !strstr(argv[2], "\n    from fmus") ||
        !strstr(argv[2], "main(sys.argv[1])") || strncmp(argv[3], "handle:", 7) != 0 || getenv("PYTHONHOME")) {
        fprintf(stderr, "started in a wrong way\n");
        return 4;
    }
    connection = (HANDLE)(size_t)strtoull(argv[3] + 7, NULL, 10);
    while (get(connection, &length, 4) && length <= sizeof bytes && get(connection, bytes, length)) {
        if (bytes[0] == 1) reply(connection, hello, 11);
        else if (bytes[0] == 3) reply(connection, outputs, 40);
        else if (bytes[0] != 4) reply(connection, NULL, 0);
        else {
            if (strcmp(mode, "hang") == 0) Sleep(600000);
            if (strcmp(mode, "dies") == 0) {
                fprintf(stderr, "Traceback\nboom\n");
                fflush(stderr);
                ExitProcess(9);
            }
            for (int i = 0; strcmp(mode, "flood") == 0 && i < 300; ++i) {
                memset(bytes, 'y', 1000);
                fwrite(bytes, 1, 1000, stderr);
                fwrite(bytes, 1, 1000, stdout);
            }
            outputs[0] += 1.0;
            reply(connection, outputs, 40);
        }
    }
    return 0;
}
