// A device plug-in that keeps in the file of its argument whether its motors pull ('1') or not ('0'): it
// outlives the process. The handle goes down by itself from 50 mm above the origin to 5 mm.
#include <fcntl.h>
#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include <palpate/device/device_plugin.h>

static int file, state;
static double first = -1.0, last;
static atomic_int stopped;

static void log_motors(const char* pull) { (void)!pwrite(file, pull, 1, 0); }

static void* create(const char* path, char* error, size_t size) {
  file = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0600);
  if (file >= 0) return &file;
  snprintf(error, size, "%s cannot be written", path);
  return NULL;
}
static void destroy(void* device) { (void)device, (void)close(file); }
static int open_device(void* device, char* error, size_t size) {
  (void)device, (void)error, (void)size;
  state = PALPATE_DEVICE_OPEN;
  return 0;
}
static int enable(void* device, char* error, size_t size) {
  (void)device, (void)error, (void)size;
  atomic_store(&stopped, 0);
  state = PALPATE_DEVICE_ENABLED;
  return 0;
}
static void stop(void* device) {
  (void)device;
  atomic_store(&stopped, 1);
  log_motors("0");
}
static void close_device(void* device) {
  stop(device);
  state = PALPATE_DEVICE_CLOSED;
}
static void capabilities(void* device, PalpateDeviceCapabilities* can) {
  (void)device;
  memset(can, 0, sizeof(*can));
  strcpy(can->name, "logged-motors");
  can->force_max = 10.0;
  can->stiffness_max = 2000.0;
  can->workspace = 0.1;
  can->rate = 1000.0;
  can->sensed_translation = can->actuated_translation = 3;
  can->watchdog = 0.05;
}
static int read_pose(void* device, double t, PalpateDeviceReading* reading) {
  (void)device;
  if (!(t > last)) return 0;
  last = t;
  if (first < 0.0) first = t;
  memset(reading, 0, sizeof(*reading));
  reading->t = t;
  reading->position[2] = fmax(0.05 - 0.02 * (t - first), 0.005);
  reading->orientation[0] = 1.0;
  return 1;
}
static void write_wrench(void* device, const PalpateDeviceWrench* wrench) {
  (void)device;
  const double* f = wrench->force;
  const int pulls = f[0] != 0.0 || f[1] != 0.0 || f[2] != 0.0;
  if (!atomic_load(&stopped)) log_motors(pulls ? "1" : "0");
}
static int status(void* device, const char** text) {
  (void)device;
  *text = "";
  return state;
}

static const PalpateDevicePlugin plugin = {
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

__attribute__((visibility("default"))) const PalpateDevicePlugin* palpate_device_plugin(
    uint32_t host_version) {
  return host_version == PALPATE_DEVICE_PLUGIN_VERSION ? &plugin : NULL;
}
