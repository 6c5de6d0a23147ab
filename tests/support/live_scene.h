// A small scene for live systems, and patience.
#pragma once

#include <string>

#include <palpate/base/clock.h>
#include <palpate/live/live_config.h>
#include <palpate/scene/ply_writer.h>
#include <palpate/study/procedural.h>

#include <support/temporary_file.h>

namespace palpate::test {

/// A plane at z = 0, as a file.
inline const std::string& plane() {
  static const TemporaryFile file(ply_bytes(make_scene(*make_surface("plane"), {}), "plane"), "plane.ply");
  static const std::string path = file.path();
  return path;
}

inline LiveConfig plane_config() {
  LiveConfig config;
  config.scene.path = plane();
  config.scene.no_index_file = true;
  return config;
}

/// Looks until `done` or for a minute: a busy machine is slow. \returns done()
template <class Done>
bool comes_true(const Done& done) {
  const double until = monotonic_now() + 60.0;
  while (!done() && monotonic_now() < until) sleep_until(monotonic_now() + 0.01);
  return done();
}

}  // namespace palpate::test
