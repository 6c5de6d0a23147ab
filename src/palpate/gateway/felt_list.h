/// \file
/// List of touchable Gaussians for renderers of the scene's file.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include <palpate/collision/scene_index.h>
#include <palpate/rosbridge/elsewhere.h>

namespace palpate {

/// Wire format of one touchable Gaussian, little-endian.
struct FeltGaussian {
  std::uint32_t row;   ///< in the scene's file
  float semi_axes[3];  ///< of its ellipsoid, along the axes of its rotation. Unit: [captured units].
};
static_assert(sizeof(FeltGaussian) == 16);

/// Returns all FeltGaussians of `index`, in no particular order.
std::string felt_list(const SceneIndex& index);

/// Maintains the felt_list() of the newest index, generated on the Elsewhere thread since it reads the whole
/// index.
class FeltListMaker {
 public:
  explicit FeltListMaker(Elsewhere elsewhere) : elsewhere_(std::move(elsewhere)) {}

  struct List {
    std::string bytes;
    std::uint64_t number = 0;  ///< changes with every list, from 1
  };

  /// Starts generating a new list if `index` holds other Gaussians than the last one. One thread, that of the
  /// `then` of `elsewhere`; it never waits for a list and never frees a list or an index.
  void follow(const std::shared_ptr<const SceneIndex>& index);

  /// Returns the newest list; null before the first is ready, and if there is no memory for it. Any thread.
  std::shared_ptr<const List> newest() const;

 private:
  void make();
  void publish(std::shared_ptr<const List> list);

  Elsewhere elsewhere_;
  std::shared_ptr<const SceneIndex> index_, made_of_;
  bool making_ = false;
  std::uint64_t count_ = 0;   ///< number of lists so far
  mutable std::mutex mutex_;  ///< guards the members below
  std::shared_ptr<const List> newest_;
};

}  // namespace palpate
