/* Prints a layer of a panorama as text: near things dark, far ones light, nothing blank.
 *   cc print_layer.c $(pkg-config --cflags --libs ldp) -o print_layer && ./print_layer room.ldp 0 */
#include <ldp.h>
#include <stdio.h>
#include <stdlib.h>

static void print(const uint16_t* disparity, int width, int height) {
  const int step_x = width < 80 ? 1 : width / 80, step_y = 2 * step_x;
  for (int y = step_y / 2; y < height; y += step_y) {
    for (int x = step_x / 2; x < width; x += step_x) {
      const uint16_t d = disparity[(size_t)y * (size_t)width + (size_t)x];
      putchar(d == LDP_NO_DISPARITY ? ' ' : ".:-=+*#%@"[d * 9 / (LDP_MOST_DISPARITY + 1)]);
    }
    putchar('\n');
  }
}

int main(int argc, char** argv) {
  ldp_panorama* panorama = NULL;
  ldp_error error;
  ldp_description told = LDP_INIT(ldp_description);
  ldp_planes planes = LDP_INIT(ldp_planes);
  if (argc != 3) return fprintf(stderr, "usage: print_layer FILE.ldp LAYER\n"), 2;
  if (ldp_open_file(argv[1], NULL, &panorama, &error) != LDP_OK) return fprintf(stderr, "%s\n", error.message), 1;
  int status = ldp_describe(panorama, &told, &error);
  if (status == LDP_OK) {
    planes.disparity = malloc(sizeof(uint16_t) * (size_t)told.width * (size_t)told.height);
    status = planes.disparity ? ldp_read_planes(panorama, atoi(argv[2]), &planes, &error) : LDP_OUT_OF_MEMORY;
  }
  if (status == LDP_OK)
    print(planes.disparity, told.width, told.height);
  else
    fprintf(stderr, "%s\n", error.message);
  free(planes.disparity);
  ldp_close(panorama);
  return status == LDP_OK ? 0 : 1;
}
