// OpenCV's static core names these for its OpenGL windows, which nothing here opens; libGLX and X11 stay at home.
#include <stdlib.h>

void* glXGetProcAddressARB(const unsigned char* name);
void* glXGetCurrentContext(void);
void* glXGetCurrentDisplay(void);

void* glXGetProcAddressARB(const unsigned char* name) {
  (void)name;
  abort();
}
void* glXGetCurrentContext(void) { abort(); }
void* glXGetCurrentDisplay(void) { abort(); }
