/* Preloaded into the program by tests: records what it does to the files of one folder, and has one
 * of these calls fail.
 *
 * CASCADE_TEST_ROOT  absolute path of the folder, which is the current one; others are let through
 * CASCADE_TEST_LOG   file for the record, a line a call: name, path, for renames the other path, and
 *                    how many calls that may fail were made until then
 * CASCADE_TEST_FAIL  number of the call that fails, from 1
 * CASCADE_TEST_ERRNO its error
 * CASCADE_TEST_REFUSE number of the request for memory that is refused, from 1, of those for LEAST bytes
 *                     and more; the record ends with a line "asked" and how many there were
 *
 * Removals are recorded but do not fail: what cannot be removed stays, whatever a program does. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#define DESCRIPTORS 1024
#define LENGTH 4096

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static char paths[DESCRIPTORS][LENGTH];
static const char *root = "";
static int record = -1, failing = 0, error = EIO, counted = 0;

/* Smaller requests are those of the C library, too. */
#define LEAST 8192
static long refused = 0;
static _Atomic long asked = 0;

/* Path within the folder, "." for itself; 0 for one elsewhere. */
static int inside(int directory, const char *path, char *out) {
    size_t length = strlen(root);
    const char *rest = path;
    const char *before = "";
    if (path[0] == '/') {
        if (strncmp(path, root, length) != 0 || (path[length] != '/' && path[length] != 0)) return 0;
        rest = path + length;
    } else if (directory != AT_FDCWD) {
        if (directory < 0 || directory >= DESCRIPTORS || !paths[directory][0]) return 0;
        if (strcmp(paths[directory], ".") != 0) before = paths[directory];
    }
    char joined[2 * LENGTH];
    snprintf(joined, sizeof joined, "%s/%s", before, rest);
    size_t n = 0;
    for (char *at = joined; *at;) {
        while (*at == '/') at++;
        size_t part = strcspn(at, "/");
        if (part > 0 && !(part == 1 && at[0] == '.') && n + part + 2 < LENGTH) {
            if (n > 0) out[n++] = '/';
            memcpy(out + n, at, part);
            n += part;
        }
        at += part;
    }
    if (n == 0) out[n++] = '.';
    out[n] = 0;
    return 1;
}

static int known(int fd, char *out) {
    if (fd < 0 || fd >= DESCRIPTORS || !paths[fd][0]) return 0;
    strcpy(out, paths[fd]);
    return 1;
}

__attribute__((constructor)) static void begin(void) {
    const char *text = getenv("CASCADE_TEST_ROOT");
    if (text) root = text;
    if ((text = getenv("CASCADE_TEST_FAIL"))) failing = atoi(text);
    if ((text = getenv("CASCADE_TEST_ERRNO"))) error = atoi(text);
    if ((text = getenv("CASCADE_TEST_REFUSE"))) refused = atol(text);
    int (*real)(const char *, int, ...) = dlsym(RTLD_NEXT, "open");
    if ((text = getenv("CASCADE_TEST_LOG"))) record = real(text, O_CREAT | O_WRONLY | O_APPEND, 0600);
}

/* Counts a call; whether it is to fail. */
static int fails(void) {
    if (++counted != failing) return 0;
    errno = error;
    return 1;
}

static void note(const char *name, const char *path, const char *other) {
    static ssize_t (*real)(int, const void *, size_t);
    if (!real) real = dlsym(RTLD_NEXT, "write");
    if (record < 0) return;
    char line[3 * LENGTH];
    int length = snprintf(line, sizeof line, "%s\t%s\t%s\t%d\n", name, path, other, counted);
    ssize_t done = real(record, line, length);
    (void)done;
}

#define REAL(type, name, ...) \
    static type (*real)(__VA_ARGS__); \
    if (!real) real = dlsym(RTLD_NEXT, #name)

/* Fails or makes a call on a descriptor of the folder. */
#define ON_DESCRIPTOR(failed, word, ...) \
    char path[LENGTH]; \
    pthread_mutex_lock(&mutex); \
    int is_known = known(fd, path); \
    if (is_known && fails()) { \
        note("fail", word, path); \
        pthread_mutex_unlock(&mutex); \
        return failed; \
    } \
    if (!is_known) { \
        pthread_mutex_unlock(&mutex); \
        return real(__VA_ARGS__); \
    } \
    __typeof__(real(__VA_ARGS__)) result = real(__VA_ARGS__); \
    int kept = errno; \
    if (result != failed) note(word, path, ""); \
    pthread_mutex_unlock(&mutex); \
    errno = kept; \
    return result

static int opened(int directory, const char *path, int flags, mode_t mode) {
    REAL(int, openat, int, const char *, int, ...);
    char own[LENGTH];
    pthread_mutex_lock(&mutex);
    int is_own = inside(directory, path, own);
    int is_removal = (flags & O_DIRECTORY) && (flags & O_NOFOLLOW);
    if (is_own && !is_removal && fails()) {
        note("fail", "open", own);
        pthread_mutex_unlock(&mutex);
        return -1;
    }
    struct stat before;
    int is_new = (flags & O_CREAT) && fstatat(directory, path, &before, 0) != 0;
    int fd = real(directory, path, flags, mode);
    int kept = errno;
    if (fd >= 0 && fd < DESCRIPTORS) {
        paths[fd][0] = 0;
        if (is_own) {
            strcpy(paths[fd], own);
            if (is_new) note("create", own, "");
            else note(flags & O_TRUNC ? "write" : "open", own, "");
        }
    }
    pthread_mutex_unlock(&mutex);
    errno = kept;
    return fd;
}

#define MODE \
    mode_t mode = 0; \
    if (flags & (O_CREAT | O_TMPFILE)) { \
        va_list rest; \
        va_start(rest, flags); \
        mode = va_arg(rest, mode_t); \
        va_end(rest); \
    }

int open(const char *path, int flags, ...) { MODE return opened(AT_FDCWD, path, flags, mode); }
int open64(const char *path, int flags, ...) { MODE return opened(AT_FDCWD, path, flags, mode); }
int openat(int directory, const char *path, int flags, ...) {
    MODE return opened(directory, path, flags, mode);
}
int openat64(int directory, const char *path, int flags, ...) {
    MODE return opened(directory, path, flags, mode);
}

int close(int fd) {
    REAL(int, close, int);
    pthread_mutex_lock(&mutex);
    if (fd >= 0 && fd < DESCRIPTORS) paths[fd][0] = 0;
    int result = real(fd);
    pthread_mutex_unlock(&mutex);
    return result;
}

ssize_t write(int fd, const void *bytes, size_t n) {
    REAL(ssize_t, write, int, const void *, size_t);
    ON_DESCRIPTOR(-1, "write", fd, bytes, n);
}
ssize_t pwrite(int fd, const void *bytes, size_t n, off_t at) {
    REAL(ssize_t, pwrite, int, const void *, size_t, off_t);
    ON_DESCRIPTOR(-1, "write", fd, bytes, n, at);
}
ssize_t pwrite64(int fd, const void *bytes, size_t n, off64_t at) {
    REAL(ssize_t, pwrite64, int, const void *, size_t, off64_t);
    ON_DESCRIPTOR(-1, "write", fd, bytes, n, at);
}
int ftruncate(int fd, off_t length) {
    REAL(int, ftruncate, int, off_t);
    ON_DESCRIPTOR(-1, "write", fd, length);
}
int ftruncate64(int fd, off64_t length) {
    REAL(int, ftruncate64, int, off64_t);
    ON_DESCRIPTOR(-1, "write", fd, length);
}
int fallocate(int fd, int mode, off_t from, off_t length) {
    REAL(int, fallocate, int, int, off_t, off_t);
    ON_DESCRIPTOR(-1, "write", fd, mode, from, length);
}
int fallocate64(int fd, int mode, off64_t from, off64_t length) {
    REAL(int, fallocate64, int, int, off64_t, off64_t);
    ON_DESCRIPTOR(-1, "write", fd, mode, from, length);
}
int fsync(int fd) {
    REAL(int, fsync, int);
    ON_DESCRIPTOR(-1, "sync", fd);
}
int fdatasync(int fd) {
    REAL(int, fdatasync, int);
    ON_DESCRIPTOR(-1, "sync", fd);
}
int flock(int fd, int how) {
    REAL(int, flock, int, int);
    ON_DESCRIPTOR(-1, "lock", fd, how);
}
void *mmap(void *address, size_t length, int access, int flags, int fd, off_t at) {
    REAL(void *, mmap, void *, size_t, int, int, int, off_t);
    ON_DESCRIPTOR(MAP_FAILED, "map", address, length, access, flags, fd, at);
}
void *mmap64(void *address, size_t length, int access, int flags, int fd, off64_t at) {
    REAL(void *, mmap64, void *, size_t, int, int, int, off64_t);
    ON_DESCRIPTOR(MAP_FAILED, "map", address, length, access, flags, fd, at);
}

/* Makes a call on one or two paths, which fails in its turn if `may_fail`. */
#define ON_PATHS(word, may_fail, directory, path, other_directory, other, call) \
    char own[LENGTH], second[LENGTH] = ""; \
    pthread_mutex_lock(&mutex); \
    int is_own = inside(directory, path, own); \
    if (other[0]) inside(other_directory, other, second); \
    if (is_own && may_fail && fails()) { \
        note("fail", word, own); \
        pthread_mutex_unlock(&mutex); \
        return -1; \
    } \
    int result = call; \
    int kept = errno; \
    if (is_own && result == 0) note(word, own, second); \
    pthread_mutex_unlock(&mutex); \
    errno = kept; \
    return result

int mkdir(const char *path, mode_t mode) {
    REAL(int, mkdir, const char *, mode_t);
    ON_PATHS("mkdir", 1, AT_FDCWD, path, AT_FDCWD, "", real(path, mode));
}
int rename(const char *from, const char *to) {
    REAL(int, rename, const char *, const char *);
    ON_PATHS("rename", 1, AT_FDCWD, from, AT_FDCWD, to, real(from, to));
}
int renameat(int a, const char *from, int b, const char *to) {
    REAL(int, renameat, int, const char *, int, const char *);
    ON_PATHS("rename", 1, a, from, b, to, real(a, from, b, to));
}
int renameat2(int a, const char *from, int b, const char *to, unsigned int flags) {
    REAL(int, renameat2, int, const char *, int, const char *, unsigned int);
    ON_PATHS(flags & 2 ? "exchange" : "rename", 1, a, from, b, to, real(a, from, b, to, flags));
}
int unlink(const char *path) {
    REAL(int, unlink, const char *);
    ON_PATHS("remove", 0, AT_FDCWD, path, AT_FDCWD, "", real(path));
}
int rmdir(const char *path) {
    REAL(int, rmdir, const char *);
    ON_PATHS("remove", 0, AT_FDCWD, path, AT_FDCWD, "", real(path));
}
int unlinkat(int directory, const char *path, int flags) {
    REAL(int, unlinkat, int, const char *, int);
    ON_PATHS("remove", 0, directory, path, AT_FDCWD, "", real(directory, path, flags));
}

extern void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t), *__libc_realloc(void *, size_t);
extern void *__libc_memalign(size_t, size_t);

static int refuses(size_t n) { return n >= LEAST && ++asked == refused; }

void *malloc(size_t n) { return refuses(n) ? NULL : __libc_malloc(n); }
void *calloc(size_t count, size_t n) { return refuses(count * n) ? NULL : __libc_calloc(count, n); }
void *realloc(void *at, size_t n) { return refuses(n) ? NULL : __libc_realloc(at, n); }
void *aligned_alloc(size_t align, size_t n) { return refuses(n) ? NULL : __libc_memalign(align, n); }
int posix_memalign(void **at, size_t align, size_t n) {
    void *found = aligned_alloc(align, n);
    if (found) *at = found;
    return found ? 0 : ENOMEM;
}

__attribute__((destructor)) static void end(void) {
    char count[32];
    snprintf(count, sizeof count, "%ld", asked);
    note("asked", count, "");
}
