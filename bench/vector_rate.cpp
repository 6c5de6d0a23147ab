#include "vector_rate.h"

#include <algorithm>

#include <palpate/study/latency.h>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vector_rate.cpp"
#include <hwy/foreach_target.h>  // before highway.h

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::bench::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// Measures twelve independent chains of multiply-adds: more than any processor executes at once. `sink`
/// prevents the compiler from removing them.
VectorRate MeasureRate() {
  using D = hn::ScalableTag<float>;
  constexpr int kRounds = 2'000'000, kTries = 10;
  const D d;
  const auto factor = hn::Set(d, 0.999F), term = hn::Set(d, 0.001F);
  double least = 1e9;
  volatile float sink = 0.0F;
  for (int attempt = 0; attempt < kTries; ++attempt) {
    auto a = hn::Set(d, sink), b = hn::Set(d, 0.1F), c = hn::Set(d, 0.2F), e = hn::Set(d, 0.3F);
    auto f = hn::Set(d, 0.4F), g = hn::Set(d, 0.5F), h = hn::Set(d, 0.6F), i = hn::Set(d, 0.7F);
    auto j = hn::Set(d, 0.8F), k = hn::Set(d, 0.9F), l = hn::Set(d, 1.1F), m = hn::Set(d, 1.2F);
    const Stopwatch watch;
    for (int round = 0; round < kRounds; ++round) {
      a = hn::MulAdd(a, factor, term);
      b = hn::MulAdd(b, factor, term);
      c = hn::MulAdd(c, factor, term);
      e = hn::MulAdd(e, factor, term);
      f = hn::MulAdd(f, factor, term);
      g = hn::MulAdd(g, factor, term);
      h = hn::MulAdd(h, factor, term);
      i = hn::MulAdd(i, factor, term);
      j = hn::MulAdd(j, factor, term);
      k = hn::MulAdd(k, factor, term);
      l = hn::MulAdd(l, factor, term);
      m = hn::MulAdd(m, factor, term);
    }
    least = std::min(least, watch.seconds());
    const auto all =
        hn::Add(hn::Add(hn::Add(hn::Add(a, b), hn::Add(c, e)), hn::Add(hn::Add(f, g), hn::Add(h, i))),
                hn::Add(hn::Add(j, k), hn::Add(l, m)));
    sink = hn::GetLane(all);
  }
  return {hwy::TargetName(HWY_TARGET), 12.0 * kRounds * static_cast<double>(hn::Lanes(d)) / least};
}

}  // namespace
}  // namespace palpate::bench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::bench {

HWY_EXPORT(MeasureRate);

VectorRate measure_vector_rate() { return HWY_DYNAMIC_DISPATCH(MeasureRate)(); }

}  // namespace palpate::bench
#endif  // HWY_ONCE
