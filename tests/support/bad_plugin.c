// A device plug-in with one thing wrong, chosen when it is compiled.
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include <palpate/device/device_plugin.h>

static int state;

static void* create(const char* arguments, char* error, size_t size) {
  (void)arguments, (void)error, (void)size;
#ifdef NO_DEVICE
  snprintf(error, size, "no arm is plugged in;\nplug it in");
  return NULL;
#endif
  return &state;
}
static void destroy(void* device) { (void)device; }
static int open_device(void* device, char* error, size_t size) {
  (void)device, (void)error, (void)size;
#ifdef CANNOT_OPEN
  memset(error, 'x', size);  // longer than there is room for, without an end
  return 1;
#endif
#ifdef OPEN_HANGS
  while (1) pause();
#endif
  state = PALPATE_DEVICE_OPEN;
#ifdef ODD_STATUS
  state = 17;
#endif
  return 0;
}
static int enable(void* device, char* error, size_t size) {
  (void)device, (void)error, (void)size;
#ifdef ENABLE_HANGS
  while (1) pause();
#endif
  state = PALPATE_DEVICE_ENABLED;
  return 0;
}
static void close_device(void* device) {
  (void)device;
#ifdef CLOSE_HANGS
  while (1) pause();
#endif
}
static void capabilities(void* device, PalpateDeviceCapabilities* can) {
  (void)device;
  memset(can, 0, sizeof(*can));
  memset(can->name, 'n', sizeof(can->name));  // without an end
  can->force_max = can->rate = 10.0;
  can->sensed_translation = can->actuated_translation = 3;
#ifdef NAN_FORCE
  can->force_max = NAN;
#endif
}
static int read_pose(void* device, double t, PalpateDeviceReading* reading) {
  (void)device, (void)t, (void)reading;
#ifdef HANGS
  while (t > 1.0) pause();
  reading->t = t;
  reading->position[2] = 0.1;
  reading->orientation[0] = 1.0;
  return 1;
#endif
  return 0;
}
static void write_wrench(void* device, const PalpateDeviceWrench* wrench) { (void)device, (void)wrench; }
static void stop(void* device) { (void)device; }
static int status(void* device, const char** text) {
  (void)device;
  *text = NULL;
  return state;
}

static PalpateDevicePlugin plugin = {
    .version = PALPATE_DEVICE_PLUGIN_VERSION,
    .size = sizeof(PalpateDevicePlugin),
    .create = create,
    .destroy = destroy,
    .open = open_device,
    .enable = enable,
    .close = close_device,
    .capabilities = capabilities,
    .read = read_pose,
    .write = write_wrench,
    .stop = stop,
    .status = status,
};

#ifdef NO_SYMBOL
#define palpate_device_plugin palpate_device_plugin_of_another_name
const PalpateDevicePlugin* palpate_device_plugin(uint32_t);
#endif

__attribute__((visibility("default"))) const PalpateDevicePlugin* palpate_device_plugin(
    uint32_t host_version) {
  (void)host_version;
#ifdef WRONG_VERSION
  plugin.version = 7;
#endif
#ifdef REFUSES_HOST
  return NULL;
#endif
#ifdef NO_READ
  plugin.read = NULL;
#endif
#ifdef WRONG_SIZE
  plugin.size -= sizeof(void*);
#endif
  return &plugin;
}
