/* The header is C; sizes and places of fields are those that programs were compiled with (64-bit). */
#include <ldp.h>
#include <stdio.h>

#if UINTPTR_MAX == UINT64_MAX
#define KEPT(type, bytes, field, place)                                             \
  _Static_assert(sizeof(type) == (bytes) && offsetof(type, field) == (place), #type \
                 " changed: fields go to the end, "                                 \
                 "and libldp.so.0 then takes the smaller struct too")
KEPT(ldp_error, 512, message, 4);
KEPT(ldp_limits, 24, memory_bytes, 16);
KEPT(ldp_description, 248, max_height, 240);
KEPT(ldp_description, 248, theta_left, 56);
KEPT(ldp_layer_description, 24, present_pixels, 16);
KEPT(ldp_camera, 208, world_from_camera, 80);
KEPT(ldp_planes, 72, stop, 64);
KEPT(ldp_planes, 72, depth, 24);
KEPT(ldp_view, 56, stop, 48);
KEPT(ldp_view, 56, rgb, 24);
#endif
_Static_assert(LDP_INTERNAL == 7 && LDP_DAMAGED == 3 && LDP_FILL_BACKGROUND == 1, "values stay");

int main(int argc, char** argv) {
  ldp_panorama* panorama = NULL;
  ldp_error error;
  ldp_description told = LDP_INIT(ldp_description);
  if (argc != 2) return 2;
  if (ldp_open_file(argv[1], NULL, &panorama, &error) != LDP_OK || ldp_describe(panorama, &told, &error) != LDP_OK) {
    fprintf(stderr, "%s\n", error.message);
    return 1;
  }
  printf("libldp %s: %dx%d, %d layers\n", ldp_version(), told.width, told.height, told.layers);
  ldp_close(panorama);
  return 0;
}
