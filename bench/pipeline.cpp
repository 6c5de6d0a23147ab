#include "pipeline.h"

#include <array>

namespace palpate::bench {

std::span<const Family> families() {
  static constexpr std::array kFamilies{
      Family{"palpate", build_palpate, false},
      Family{kPaper, build_paper, true},
      Family{"paper-complete", build_complete_paper, true},
      Family{"fcl", build_fcl, true},
      Family{"bullet", build_bullet, true},
      Family{"embree", build_embree, true},
  };
  return kFamilies;
}

}  // namespace palpate::bench
