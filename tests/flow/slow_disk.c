// Preloaded before a program: flushing a photo to disk waits until the file named by LDP_DISK_GATE is there.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

int fsync(int fd) {
  char link[32], name[4096] = "";
  snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  const ssize_t length = readlink(link, name, sizeof name - 1);
  const char* const gate = getenv("LDP_DISK_GATE");
  const struct timespec pause = {.tv_nsec = 5000000};
  while (gate && length > 0 && strstr(name, ".jpg") && access(gate, F_OK) != 0) nanosleep(&pause, NULL);
  int (*const flush)(int) = (int (*)(int))dlsym(RTLD_NEXT, "fsync");
  return flush(fd);
}
