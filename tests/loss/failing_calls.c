/* Loaded before a program (LD_PRELOAD): the calls that write a file fail as told.
 *
 *   PTET_FAIL_PATH   what the path of the file must contain for a call to count
 *   PTET_FAIL_CALL   the call that fails, from 1; 0 or none: no one
 *   PTET_FAIL_HOW    ENOSPC or EIO: it and, for writes, all later ones; KILL: the program ends there, writes half done
 *   PTET_FAIL_CHUNK  no write takes more bytes at a time than this
 *   PTET_FAIL_LOG    file in which each counted call leaves a line: its name
 *
 * Counted are the opening of a file to write, write, writev, fsync, rename. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

static long calls_so_far;
static int writes_fail;

static int counts(const char* path) {
  const char* const wanted = getenv("PTET_FAIL_PATH");
  return wanted && path && strstr(path, wanted) != NULL;
}

static int counts_descriptor(int descriptor) {
  char link[64], path[4096];
  snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
  const ssize_t length = readlink(link, path, sizeof path - 1);
  if (length < 0) return 0;
  path[length] = '\0';
  return counts(path);
}

static void leave_line(const char* name) {
  const char* const log = getenv("PTET_FAIL_LOG");
  if (!log) return;
  const int descriptor = (int)syscall(SYS_openat, AT_FDCWD, log, O_WRONLY | O_APPEND | O_CREAT, 0666);
  if (descriptor < 0) return;
  char line[32];
  const int length = snprintf(line, sizeof line, "%s\n", name);
  syscall(SYS_write, descriptor, line, (size_t)length);
  syscall(SYS_close, descriptor);
}

/* Counts the call; whether it is the one that fails. */
static int is_the_one(const char* name) {
  const char* const call = getenv("PTET_FAIL_CALL");
  leave_line(name);
  return call && ++calls_so_far == atol(call);
}

static int how_is(const char* how) {
  const char* const told = getenv("PTET_FAIL_HOW");
  return told && strcmp(told, how) == 0;
}

/* Ends the program, or sets errno. */
static void fail(void) {
  if (how_is("KILL")) {
    kill(getpid(), SIGKILL);
    pause();
  }
  errno = how_is("EIO") ? EIO : ENOSPC;
}

ssize_t write(int descriptor, const void* bytes, size_t count) {
  if (!counts_descriptor(descriptor)) return syscall(SYS_write, descriptor, bytes, count);
  if (is_the_one("write")) writes_fail = 1;
  if (writes_fail) {
    if (how_is("KILL")) syscall(SYS_write, descriptor, bytes, count / 2);
    fail();
    return -1;
  }
  const char* const chunk = getenv("PTET_FAIL_CHUNK");
  if (chunk && count > strtoul(chunk, NULL, 10)) count = strtoul(chunk, NULL, 10);
  return syscall(SYS_write, descriptor, bytes, count);
}

ssize_t writev(int descriptor, const struct iovec* parts, int count) {
  if (!counts_descriptor(descriptor)) return syscall(SYS_writev, descriptor, parts, count);
  /* One part at a time is a short write, too. */
  for (int i = 0; i < count; ++i)
    if (parts[i].iov_len > 0) return write(descriptor, parts[i].iov_base, parts[i].iov_len);
  return 0;
}

int fsync(int descriptor) {
  if (counts_descriptor(descriptor) && is_the_one("fsync")) {
    fail();
    return -1;
  }
  return (int)syscall(SYS_fsync, descriptor);
}

int rename(const char* from, const char* to) {
  if (counts(from) && is_the_one("rename")) {
    fail();
    return -1;
  }
  return (int)syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0);
}

static int open_any(const char* path, int flags, mode_t mode) {
  if ((flags & O_ACCMODE) != O_RDONLY && counts(path) && is_the_one("open")) {
    fail();
    return -1;
  }
  return (int)syscall(SYS_openat, AT_FDCWD, path, flags, mode);
}

int open(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) ? va_arg(rest, mode_t) : 0;
  va_end(rest);
  return open_any(path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) ? va_arg(rest, mode_t) : 0;
  va_end(rest);
  return open_any(path, flags | O_LARGEFILE, mode);
}

/* libstdc++ opens its files by these. */
static FILE* open_stream(const char* name, const char* path, const char* mode) {
  FILE* (*next)(const char*, const char*);
  *(void**)&next = dlsym(RTLD_NEXT, name);
  if (mode[0] != 'r' && counts(path) && is_the_one("open")) {
    fail();
    return NULL;
  }
  return next(path, mode);
}

FILE* fopen(const char* path, const char* mode) {
  return open_stream("fopen", path, mode);
}

FILE* fopen64(const char* path, const char* mode) {
  return open_stream("fopen64", path, mode);
}
