#include <palpate/gateway/felt_list.h>

#include <bit>
#include <chrono>
#include <cmath>

namespace palpate {
namespace {

static_assert(std::endian::native == std::endian::little, "FeltGaussian is sent as it is in memory");

/// True if the two share their memory. Both must be alive: an address alone may be another's later.
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
  index_ = index;
  if (!making_.valid()) make();
}

bool FeltListMaker::update() {
  using namespace std::chrono_literals;
  if (!making_.valid() || making_.wait_for(0s) != std::future_status::ready) return false;
  bytes_ = std::make_shared<const std::string>(making_.get());
  if (!same_gaussians(made_of_, index_)) make();
  return true;
}

void FeltListMaker::make() {
  made_of_ = index_;
  making_ = std::async(std::launch::async, [index = index_] { return felt_list(*index); });
}

}  // namespace palpate
