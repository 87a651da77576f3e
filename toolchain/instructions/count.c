// A plugin of qemu-user (interface version 1, QEMU 4.2 and later): how many instructions ran at each address. At the
// end it writes lines "COUNT ADDRESS" in hexadecimal to the file named by LDP_INSTRUCTIONS, then the process's memory
// map. Counts are exact for one thread. The declarations are those of qemu-plugin.h, which no Debian package holds.
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

typedef uint64_t qemu_plugin_id_t;
typedef struct qemu_info_t qemu_info_t;
struct qemu_plugin_tb;
enum { kInlineAdd = 0 };
void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t, void (*)(qemu_plugin_id_t, struct qemu_plugin_tb*));
void qemu_plugin_register_vcpu_tb_exec_inline(struct qemu_plugin_tb*, int operation, void* counter, uint64_t addend);
void qemu_plugin_register_atexit_cb(qemu_plugin_id_t, void (*)(qemu_plugin_id_t, void*), void*);
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb*);
uint64_t qemu_plugin_tb_vaddr(const struct qemu_plugin_tb*);

__attribute__((visibility("default"))) int qemu_plugin_version = 1;

struct block {
  uint64_t address, count;
  struct block* before;
};
static struct block* blocks = NULL;

static void translated(qemu_plugin_id_t id, struct qemu_plugin_tb* tb) {
  (void)id;
  struct block* b = malloc(sizeof *b);
  if (!b) abort();
  *b = (struct block){qemu_plugin_tb_vaddr(tb), 0, blocks};
  blocks = b;
  qemu_plugin_register_vcpu_tb_exec_inline(tb, kInlineAdd, &b->count, qemu_plugin_tb_n_insns(tb));
}

static void finished(qemu_plugin_id_t id, void* data) {
  (void)id, (void)data;
  const char* name = getenv("LDP_INSTRUCTIONS");
  FILE* out = fopen(name ? name : "instructions.txt", "w");
  FILE* maps = fopen("/proc/self/maps", "r");
  if (!out || !maps) abort();
  for (const struct block* b = blocks; b; b = b->before) {
    if (b->count) fprintf(out, "%llx %llx\n", (unsigned long long)b->count, (unsigned long long)b->address);
  }
  char line[4096];
  while (fgets(line, sizeof line, maps)) fprintf(out, "map %s", line);
  fclose(maps);
  fclose(out);
}

__attribute__((visibility("default"))) int qemu_plugin_install(qemu_plugin_id_t id, const qemu_info_t* info, int argc,
                                                               char** argv) {
  (void)info, (void)argc, (void)argv;
  qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
  qemu_plugin_register_atexit_cb(id, finished, NULL);
  return 0;
}
