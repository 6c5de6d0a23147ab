// Contacts of a scene, bit by bit: what a consumer gets must not depend on how it is compiled.
#include <cinttypes>
#include <cstdio>
#include <cstring>

#include <palpate/collision/open_index.h>

namespace {

void print(double value) {
  std::uint64_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  std::printf(" %016" PRIx64, bits);
}

void touch_at(const palpate::SceneIndex& index, const palpate::Pose& pose) {
  palpate::ContactSet found;
  index.query(palpate::Ellipsoid::from_semi_axes(pose, {0.02, 0.02, 0.03}), found);
  for (const palpate::Contact& contact : found.contacts) {
    std::printf("%u", static_cast<unsigned>(contact.id));
    for (const double value : {contact.k_min, contact.lambda, contact.depth, contact.extent}) print(value);
    for (int k = 0; k < 3; ++k) {
      print(contact.point[k]);
      print(contact.normal[k]);
    }
    std::printf("\n");
  }
}

}  // namespace

/// Prints all contacts at the nodes of a grid of 62.5 mm, in two orientations. What is asked is the same
/// however the compiler rounds.
extern "C" void touch(const char* path) {
  const palpate::OpenedIndex opened = palpate::open_index(path, {}, {});
  const Eigen::Quaterniond turned[] = {{1.0, 0.0, 0.0, 0.0},
                                       {0.9238795325112867, 0.0, 0.3826834323650898, 0.0}};
  for (int i = 0; i < 125; ++i) {
    const Eigen::Vector3d node(i % 5 - 2, i / 5 % 5 - 2, i / 25 - 2);
    for (const Eigen::Quaterniond& orientation : turned) touch_at(opened.index, {0.0625 * node, orientation});
  }
  std::fflush(stdout);
}
