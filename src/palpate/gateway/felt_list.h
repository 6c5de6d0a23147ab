/// \file
/// What a hand can feel, for whoever draws the scene's file.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include <palpate/collision/scene_index.h>
#include <palpate/rosbridge/elsewhere.h>

namespace palpate {

/// One Gaussian that can be touched, as it is sent: little-endian.
struct FeltGaussian {
  std::uint32_t row;   ///< in the scene's file
  float semi_axes[3];  ///< of its ellipsoid, along the axes of its rotation. Unit: [captured units].
};
static_assert(sizeof(FeltGaussian) == 16);

/// All FeltGaussians of `index`, in no particular order.
std::string felt_list(const SceneIndex& index);

/// The felt_list() of the newest index, made elsewhere: it reads all of the index.
class FeltListMaker {
 public:
  explicit FeltListMaker(Elsewhere elsewhere) : elsewhere_(std::move(elsewhere)) {}

  struct List {
    std::string bytes;
    std::uint64_t number = 0;  ///< another for every list, from 1
  };

  /// Another list is made if `index` holds other Gaussians than the last one. One thread, that of the `then`
  /// of `elsewhere`, which never waits for a list, and never lets one or an index go.
  void follow(const std::shared_ptr<const SceneIndex>& index);

  /// Null before the first is there, and where there is no memory for it. Any thread.
  std::shared_ptr<const List> newest() const;

 private:
  void make();
  void publish(std::shared_ptr<const List> list);

  Elsewhere elsewhere_;
  std::shared_ptr<const SceneIndex> index_, made_of_;
  bool making_ = false;
  std::uint64_t count_ = 0;   ///< of lists
  mutable std::mutex mutex_;  ///< of what follows
  std::shared_ptr<const List> newest_;
};

}  // namespace palpate
