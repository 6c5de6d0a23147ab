#include <palpate/gateway/felt_list.h>

#include <bit>
#include <cmath>
#include <new>
#include <utility>

namespace palpate {
namespace {

static_assert(std::endian::native == std::endian::little, "FeltGaussian is sent as it is in memory");

/// Returns whether both share their memory. Both must be alive: the address of a freed index may be reused.
bool same_gaussians(const std::shared_ptr<const SceneIndex>& a, const std::shared_ptr<const SceneIndex>& b) {
  return a && b && a->view().nodes.data() == b->view().nodes.data();
}

}  // namespace

std::string felt_list(const SceneIndex& index) {
  std::string bytes;
  bytes.reserve(sizeof(FeltGaussian) * index.size());
  for (const GaussianBlock& block : index.view().blocks) {
    for (std::size_t i = 0; i < kIndexWidth; ++i) {
      if (std::isnan(block.position[0][i])) continue;  // a lane without a Gaussian
      const auto& length = block.length_high;
      const FeltGaussian one{block.id[i], {length[0][i], length[1][i], length[2][i]}};
      bytes.append(reinterpret_cast<const char*>(&one), sizeof one);
    }
  }
  return bytes;
}

void FeltListMaker::follow(const std::shared_ptr<const SceneIndex>& index) {
  if (same_gaussians(index, index_)) return;
  // Releasing the last reference to an index frees its memory, perhaps gigabytes, which is slow.
  elsewhere_([old = std::exchange(index_, index)] {}, [] {});
  if (!making_) make();
}

void FeltListMaker::make() {
  making_ = true;
  const auto work = [this, index = index_, number = ++count_] {
    std::shared_ptr<List> list;
    try {
      list = std::make_shared<List>(List{felt_list(*index), number});
    } catch (const std::bad_alloc&) {
      // published as null: an old list would be of another scene
    }
    publish(std::move(list));
  };
  elsewhere_([work, old = std::exchange(made_of_, index_)] { work(); },
             [this] {
               making_ = false;
               if (!same_gaussians(made_of_, index_)) make();
             });
}

/// Called on the Elsewhere thread: freeing the previous list may be slow.
void FeltListMaker::publish(std::shared_ptr<const List> list) {
  const std::scoped_lock lock(mutex_);
  newest_.swap(list);
}

std::shared_ptr<const FeltListMaker::List> FeltListMaker::newest() const {
  const std::scoped_lock lock(mutex_);
  return newest_;
}

}  // namespace palpate
