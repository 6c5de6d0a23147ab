// Preloaded: the host "localhost" has two addresses, and nobody listens at the first, as at ::1 where a node
// listens at 127.0.0.1.
#include <cstring>

#include <dlfcn.h>
#include <netdb.h>

extern "C" __attribute__((visibility("default"))) int getaddrinfo(const char* host, const char* service,
                                                                  const addrinfo* hints, addrinfo** found) {
  static const auto look_up = reinterpret_cast<decltype(&getaddrinfo)>(dlsym(RTLD_NEXT, "getaddrinfo"));
  if (host == nullptr || std::strcmp(host, "localhost") != 0) return look_up(host, service, hints, found);
  if (const int error = look_up("127.0.0.2", service, hints, found); error != 0) return error;
  return look_up("127.0.0.1", service, hints, &(*found)->ai_next);
}
