/// \file
/// Runs a test on every instruction set that this processor has.
#pragma once

#include <string>
#include <type_traits>

#include <gtest/gtest.h>

#include <palpate/collision/simd_target.h>

namespace palpate::test {

class OnEveryTarget : public testing::Test {
 protected:
  void TearDown() override { use_simd_target(""); }

  /// Calls body(name) or body() on each, and stops at the first that fails.
  template <typename Body>
  static void on_every_target(const Body& body) {
    for (const std::string& target : simd_targets()) {
      SCOPED_TRACE(target);
      use_simd_target(target);
      if constexpr (std::is_invocable_v<Body, const std::string&>) {
        body(target);
      } else {
        body();
      }
      if (HasFailure()) break;
    }
    use_simd_target("");
  }
};

}  // namespace palpate::test
