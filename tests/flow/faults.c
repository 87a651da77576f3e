// Preloaded before a program: makes chosen system calls fail, wait or lie, as a full disk or a bad card would.
//
//   LDP_FAULTS     rules separated by ';', each CALL MATCH WHICH ACTION [ARGUMENT]:
//     CALL         open read write fsync mmap rename unlink mkdir statvfs pipe fork thread malloc clock accept epoll
//     MATCH        part of the file's path, its end before '$' ('-' = any); of malloc: the least size in bytes
//     WHICH        3 = the third such call of the process, 3+ = that and all later ones, * = all
//     ACTION       an errno by name (ENOSPC ...); short (half of a read or write); delay MILLISECONDS; wait FILE (until
//     the file
//                  is there); shift SECONDS (of clock: the wall clock is that much off)
//   LDP_FAULTS_IN  name of the only program that is meant; others that inherit the variables are left alone
//   LDP_FAULTS_WHILE  only while this file is there
//   LDP_FAULTS_RECORD folder: on standard error, a file that is appended to, a line in its place among those of the
//     program for all that changes a folder or makes it last: @open, @rename, @unlink, @mkdir, @sync with tabs between
//     paths; what a file held when it was flushed is kept in the folder under the number that ends its line
//   LDP_FAULTS_LOG file to which every action is appended as a line, and "polls N", the main thread's, at the end
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#define MOST_RULES 8

struct rule {
  char call[16], match[64], action[16], argument[256];
  long first, last;  // which calls, counted from 1
  atomic_long calls;
};

static struct rule rules[MOST_RULES];
static int rule_count;
static const char* log_file;
static const char* while_file;
static const char* record_folder;
static atomic_long polls;

static void* libc(const char* name) { return dlsym(RTLD_NEXT, name); }

static const struct {
  const char* name;
  int number;
} kErrors[] = {{"ENOSPC", ENOSPC}, {"EIO", EIO},       {"EROFS", EROFS},   {"EINTR", EINTR},   {"EMFILE", EMFILE},
               {"ENOMEM", ENOMEM}, {"EAGAIN", EAGAIN}, {"EINVAL", EINVAL}, {"EACCES", EACCES}, {"ENXIO", ENXIO}};

static int error_of(const char* name) {
  for (size_t i = 0; i < sizeof kErrors / sizeof *kErrors; ++i)
    if (strcmp(kErrors[i].name, name) == 0) return kErrors[i].number;
  return 0;
}

static void parse(const char* text) {
  while (*text != '\0' && rule_count < MOST_RULES) {
    struct rule* const rule = &rules[rule_count];
    char which[24] = "";
    int used = 0;
    const int fields = sscanf(text, " %15s %63s %23s %15[^; ]%n %255[^; ]%n", rule->call, rule->match, which,
                              rule->action, &used, rule->argument, &used);
    if (fields < 4) {
      fprintf(stderr, "LDP_FAULTS: cannot read '%s'\n", text);
      abort();
    }
    rule->first = which[0] == '*' ? 1 : atol(which);
    rule->last = which[0] == '*' || strchr(which, '+') ? __LONG_MAX__ : rule->first;
    ++rule_count;
    text = strchr(text + used, ';') ? strchr(text + used, ';') + 1 : "";
  }
}

__attribute__((constructor)) static void begin(void) {
  const char* const only = getenv("LDP_FAULTS_IN");
  if (only && strcmp(only, program_invocation_short_name) != 0) return;
  log_file = getenv("LDP_FAULTS_LOG");
  while_file = getenv("LDP_FAULTS_WHILE");
  record_folder = getenv("LDP_FAULTS_RECORD");
  if (getenv("LDP_FAULTS")) parse(getenv("LDP_FAULTS"));
}

// By the system calls themselves: nothing here may be acted upon.
static void note(const char* line) {
  const int kept = errno;
  const int fd =
      log_file ? (int)syscall(SYS_openat, AT_FDCWD, log_file, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644) : -1;
  if (fd >= 0) {
    syscall(SYS_write, fd, line, strlen(line));
    syscall(SYS_close, fd);
  }
  errno = kept;
}

__attribute__((destructor)) static void end(void) {
  char line[64];
  snprintf(line, sizeof line, "polls %ld\n", atomic_load(&polls));
  note(line);
}

// Held around what is recorded, so that the lines are in the order of the deeds.
static pthread_mutex_t recording = PTHREAD_MUTEX_INITIALIZER;
static void begin_record(void) {
  if (record_folder) pthread_mutex_lock(&recording);
}
static void end_record(bool done, const char* what, const char* path, const char* more) {
  if (!record_folder) return;
  const int kept = errno;
  char line[8300];
  const int length = snprintf(line, sizeof line, "@%s\t%s\t%s\n", what, path, more);
  if (done) syscall(SYS_write, STDERR_FILENO, line, length);
  pthread_mutex_unlock(&recording);
  errno = kept;
}

// What a file holds, copied into the folder of the record; its number as text, "-" of a folder.
static void keep_content(int fd, char number[24]) {
  static long count;
  struct stat status;
  snprintf(number, 24, "-");
  if (fstat(fd, &status) != 0 || !S_ISREG(status.st_mode)) return;
  snprintf(number, 24, "%ld", ++count);
  char name[4300], path[32], bytes[4096];
  snprintf(name, sizeof name, "%s/%s", record_folder, number);
  snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
  const int from = (int)syscall(SYS_openat, AT_FDCWD, path, O_RDONLY | O_CLOEXEC);
  const int to = (int)syscall(SYS_openat, AT_FDCWD, name, O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
  for (ssize_t got; (got = syscall(SYS_read, from, bytes, sizeof bytes)) > 0;) syscall(SYS_write, to, bytes, got);
  syscall(SYS_close, from);
  syscall(SYS_close, to);
}

static void pause_ms(long ms) {
  const struct timespec time = {ms / 1000, ms % 1000 * 1000000};
  nanosleep(&time, NULL);
}

static bool matches(const char* match, const char* path, size_t size) {
  if (strcmp(match, "-") == 0) return true;
  if (!path) return size >= (size_t)atol(match);
  const size_t length = strlen(match);
  if (match[length - 1] != '$') return strstr(path, match) != NULL;
  const size_t all = strlen(path);
  return all + 1 >= length && strncmp(path + all + 1 - length, match, length - 1) == 0;
}

// The rule that holds for this call, having waited where it says so.
static const struct rule* rule_for(const char* call, const char* path, size_t size) {
  for (int i = 0; i < rule_count; ++i) {
    struct rule* const rule = &rules[i];
    if (strcmp(rule->call, call) != 0) continue;
    if (!matches(rule->match, path, size)) continue;
    if (while_file && access(while_file, F_OK) != 0) continue;
    const long number = atomic_fetch_add(&rule->calls, 1) + 1;
    if (number < rule->first || number > rule->last) continue;
    if (strcmp(call, "clock") != 0) {
      char line[512];
      snprintf(line, sizeof line, "%s %s %s\n", call, path ? path : "-", rule->action);
      note(line);
    }
    if (strcmp(rule->action, "delay") == 0) pause_ms(atol(rule->argument));
    while (strcmp(rule->action, "wait") == 0 && access(rule->argument, F_OK) != 0) pause_ms(5);
    return rule;
  }
  return NULL;
}

// Whether the call is to fail, with errno set.
static bool fails(const char* call, const char* path, size_t size) {
  const struct rule* const rule = rule_count > 0 ? rule_for(call, path, size) : NULL;
  const int error = rule ? error_of(rule->action) : 0;
  if (error != 0) errno = error;
  return error != 0;
}

static const char* path_of(int fd, char name[4096]) {
  char link[32];
  snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  const ssize_t length = rule_count > 0 || record_folder ? readlink(link, name, 4095) : 0;
  name[length > 0 ? length : 0] = '\0';
  return name;
}

static int open_by(const char* name, int folder, const char* path, int flags, mode_t mode) {
  if (fails("open", path, 0)) return -1;
  int (*const next)(int, const char*, int, ...) = (int (*)(int, const char*, int, ...))libc(name);
  if (!(flags & O_CREAT)) return next(folder, path, flags, mode);
  begin_record();
  const int fd = next(folder, path, flags, mode);
  end_record(fd >= 0, "open", path, "");
  return fd;
}

#define MODE_FROM(flags)                                                            \
  va_list more;                                                                     \
  va_start(more, flags);                                                            \
  const mode_t mode = (flags) & (O_CREAT | __O_TMPFILE) ? va_arg(more, mode_t) : 0; \
  va_end(more)

int open(const char* path, int flags, ...) {
  MODE_FROM(flags);
  return open_by("openat", AT_FDCWD, path, flags, mode);
}
int open64(const char* path, int flags, ...) {
  MODE_FROM(flags);
  return open_by("openat64", AT_FDCWD, path, flags, mode);
}
int openat(int folder, const char* path, int flags, ...) {
  MODE_FROM(flags);
  return open_by("openat", folder, path, flags, mode);
}
int openat64(int folder, const char* path, int flags, ...) {
  MODE_FROM(flags);
  return open_by("openat64", folder, path, flags, mode);
}

// How many bytes of a read or write get through; -1 with errno set: it fails.
static ssize_t allowed(const char* call, int fd, size_t count) {
  char name[4096];
  const struct rule* const rule = rule_count > 0 ? rule_for(call, path_of(fd, name), 0) : NULL;
  if (!rule) return (ssize_t)count;
  if (error_of(rule->action) != 0) {
    errno = error_of(rule->action);
    return -1;
  }
  return (ssize_t)(count > 1 && strcmp(rule->action, "short") == 0 ? count / 2 : count);
}

ssize_t read(int fd, void* bytes, size_t count) {
  const ssize_t part = allowed("read", fd, count);
  return part < 0 ? -1 : syscall(SYS_read, fd, bytes, part);
}

ssize_t write(int fd, const void* bytes, size_t count) {
  const ssize_t part = allowed("write", fd, count);
  return part < 0 ? -1 : syscall(SYS_write, fd, bytes, part);
}

static void* map_by(const char* next, void* at, size_t size, int protection, int flags, int fd, off_t offset) {
  char name[4096];
  if (fd >= 0 && fails("mmap", path_of(fd, name), 0)) return MAP_FAILED;
  return ((void* (*)(void*, size_t, int, int, int, off_t))libc(next))(at, size, protection, flags, fd, offset);
}
void* mmap(void* at, size_t size, int protection, int flags, int fd, off_t offset) {
  return map_by("mmap", at, size, protection, flags, fd, offset);
}
void* mmap64(void* at, size_t size, int protection, int flags, int fd, off_t offset) {
  return map_by("mmap64", at, size, protection, flags, fd, offset);
}

int fsync(int fd) {
  char name[4096];
  if (fails("fsync", path_of(fd, name), 0)) return -1;
  begin_record();
  const int result = ((int (*)(int))libc("fsync"))(fd);
  char number[24];
  if (record_folder) keep_content(fd, number);
  end_record(result == 0, "sync", name, number);
  return result;
}

int rename(const char* from, const char* to) {
  if (fails("rename", to, 0)) return -1;
  begin_record();
  const int result = ((int (*)(const char*, const char*))libc("rename"))(from, to);
  end_record(result == 0, "rename", from, to);
  return result;
}

int unlink(const char* path) {
  if (fails("unlink", path, 0)) return -1;
  begin_record();
  const int result = ((int (*)(const char*))libc("unlink"))(path);
  end_record(result == 0, "unlink", path, "");
  return result;
}

int remove(const char* path) {
  if (fails("unlink", path, 0)) return -1;
  begin_record();
  const int result = ((int (*)(const char*))libc("remove"))(path);
  end_record(result == 0, "unlink", path, "");
  return result;
}

int statvfs64(const char* path, struct statvfs64* status) {
  if (fails("statvfs", path, 0)) return -1;
  return ((int (*)(const char*, struct statvfs64*))libc("statvfs64"))(path, status);
}
int statvfs(const char* path, struct statvfs* status) {
  if (fails("statvfs", path, 0)) return -1;
  return ((int (*)(const char*, struct statvfs*))libc("statvfs"))(path, status);
}

int pipe2(int ends[2], int flags) {
  if (fails("pipe", "", 0)) return -1;
  return ((int (*)(int[2], int))libc("pipe2"))(ends, flags);
}

int socketpair(int domain, int type, int protocol, int ends[2]) {
  if (fails("pipe", "", 0)) return -1;
  return ((int (*)(int, int, int, int[2]))libc("socketpair"))(domain, type, protocol, ends);
}

int mkdir(const char* path, mode_t mode) {
  if (fails("mkdir", path, 0)) return -1;
  begin_record();
  const int result = ((int (*)(const char*, mode_t))libc("mkdir"))(path, mode);
  end_record(result == 0, "mkdir", path, "");
  return result;
}

int unlinkat(int folder, const char* path, int flags) {
  if (fails("unlink", path, 0)) return -1;
  return ((int (*)(int, const char*, int))libc("unlinkat"))(folder, path, flags);
}

int accept4(int listening, struct sockaddr* address, socklen_t* size, int flags) {
  if (fails("accept", "", 0)) return -1;
  return (int)syscall(SYS_accept4, listening, address, size, flags);
}

int epoll_ctl(int epoll, int operation, int fd, struct epoll_event* event) {
  if (operation == EPOLL_CTL_ADD && fails("epoll", "", 0)) return -1;
  return ((int (*)(int, int, int, struct epoll_event*))libc("epoll_ctl"))(epoll, operation, fd, event);
}

pid_t fork(void) {
  if (fails("fork", "", 0)) return -1;
  return ((pid_t(*)(void))libc("fork"))();
}

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*run)(void*), void* argument) {
  if (fails("thread", "", 0)) return errno;
  int (*const next)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*) =
      (int (*)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*))libc("pthread_create");
  return next(thread, attributes, run, argument);
}

#ifndef LDP_SANITIZED  // a sanitizer's own
extern void* __libc_malloc(size_t size);
void* malloc(size_t size) { return fails("malloc", NULL, size) ? NULL : __libc_malloc(size); }
#endif

int clock_gettime(clockid_t clock, struct timespec* time) {
  const long result = syscall(SYS_clock_gettime, clock, time);
  const struct rule* const rule = clock == CLOCK_REALTIME && rule_count > 0 ? rule_for("clock", "", 0) : NULL;
  if (rule && strcmp(rule->action, "shift") == 0) time->tv_sec += atol(rule->argument);
  return (int)result;
}

int poll(struct pollfd* entries, nfds_t count, int timeout_ms) {
  if (syscall(SYS_gettid) == getpid()) atomic_fetch_add(&polls, 1);
  return ((int (*)(struct pollfd*, nfds_t, int))libc("poll"))(entries, count, timeout_ms);
}
