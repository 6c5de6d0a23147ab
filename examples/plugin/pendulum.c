// A device plug-in in C: a handle that swings up and down by itself, as a motion platform would move it.
//   palpate run --device plugin:./pendulum.so:HEIGHT     the lowest point of the swing, m (default 0)
#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <palpate/device/device_plugin.h>

#define SWING 0.03  // m, from the middle to either end
#define SPEED 3.0   // rad/s

struct Pendulum {
  double height;
  double told;  // time of the last reading
  atomic_int status;
  atomic_int motors_on;
  PalpateDeviceWrench shown;  // by the motors, if there were any
};

static void* create(const char* arguments, char* error, size_t size) {
  char* end = NULL;
  const double height = strtod(arguments, &end);
  if (*end != '\0' || !isfinite(height)) {
    snprintf(error, size, "'%s' is no height in m; give plugin:pendulum.so:0.1", arguments);
    return NULL;
  }
  struct Pendulum* device = calloc(1, sizeof(*device));
  if (device == NULL) {
    snprintf(error, size, "no memory; close other programs");
    return NULL;
  }
  device->height = height;
  device->told = -1.0;
  return device;
}

static void destroy(void* device) { free(device); }

static int open_device(void* device, char* error, size_t size) {
  (void)error, (void)size;  // nothing to connect to: a driver tells here what to switch on
  atomic_store(&((struct Pendulum*)device)->status, PALPATE_DEVICE_OPEN);
  return 0;
}

static int enable(void* device, char* error, size_t size) {
  struct Pendulum* d = device;
  if (atomic_load(&d->status) != PALPATE_DEVICE_OPEN) {
    snprintf(error, size, "it is not open; open it first");
    return 1;
  }
  memset(&d->shown, 0, sizeof(d->shown));
  atomic_store(&d->status, PALPATE_DEVICE_ENABLED);
  return 0;
}

static void stop(void* device) { atomic_store(&((struct Pendulum*)device)->motors_on, 0); }

static void close_device(void* device) {
  stop(device);
  atomic_store(&((struct Pendulum*)device)->status, PALPATE_DEVICE_CLOSED);
}

static void capabilities(void* device, PalpateDeviceCapabilities* can) {
  (void)device;
  memset(can, 0, sizeof(*can));
  strcpy(can->name, "pendulum");
  can->force_max = 10.0;
  can->stiffness_max = 2000.0;
  can->damping_max = 10.0;
  can->workspace = 0.1;
  can->rate = 1000.0;
  can->sensed_translation = can->actuated_translation = 3;
  can->watchdog = 0.05;
}

static int read_pose(void* device, double t, PalpateDeviceReading* reading) {
  struct Pendulum* d = device;
  if (!(t > d->told)) return 0;
  d->told = t;
  memset(reading, 0, sizeof(*reading));
  reading->t = t;
  reading->position[2] = d->height + SWING * (1.0 + cos(SPEED * t));
  reading->orientation[0] = 1.0;
  reading->linear_velocity[2] = -SWING * SPEED * sin(SPEED * t);
  return 1;
}

static void write_wrench(void* device, const PalpateDeviceWrench* wrench) {
  struct Pendulum* d = device;
  d->shown = *wrench;
  atomic_store(&d->motors_on, atomic_load(&d->status) == PALPATE_DEVICE_ENABLED);
}

static int status(void* device, const char** text) {
  *text = "";
  return atomic_load(&((struct Pendulum*)device)->status);
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
