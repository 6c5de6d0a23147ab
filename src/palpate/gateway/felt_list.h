/// \file
/// What a hand can feel, for whoever draws the scene's file.
#pragma once

#include <cstdint>
#include <future>
#include <memory>
#include <string>

#include <palpate/collision/scene_index.h>

namespace palpate {

/// One Gaussian that can be touched, as it is sent: little-endian.
struct FeltGaussian {
  std::uint32_t row;   ///< in the scene's file
  float semi_axes[3];  ///< of its ellipsoid, along the axes of its rotation. Unit: [captured units].
};
static_assert(sizeof(FeltGaussian) == 16);

/// All FeltGaussians of `index`, in no particular order.
std::string felt_list(const SceneIndex& index);

/// The felt_list() of the newest index, made on a thread of its own: it reads all of the index. Used by one
/// thread, which never waits.
class FeltListMaker {
 public:
  /// Another list is made if `index` holds other Gaussians than the last one.
  void follow(const std::shared_ptr<const SceneIndex>& index);
  /// To be called now and then. \returns true if another list is there.
  bool update();

  /// Null before the first is there.
  const std::shared_ptr<const std::string>& bytes() const { return bytes_; }

 private:
  void make();

  std::shared_ptr<const SceneIndex> index_, made_of_;
  std::shared_ptr<const std::string> bytes_;
  std::future<std::string> making_;
};

}  // namespace palpate
