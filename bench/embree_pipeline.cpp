// Embree: ellipsoids as user geometry, a point query with the tool's bounding sphere, then the paper's narrow
// phase.
#include <cmath>
#include <limits>
#include <memory>
#include <type_traits>

#include <embree3/rtcore.h>

#include <palpate/base/error.h>

#include "golden_narrow_phase.h"
#include "pipeline.h"

namespace palpate::bench {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Bounds of primitive `primID` in Embree's single precision, widened by one step against rounding.
void ellipsoid_bounds(const RTCBoundsFunctionArguments* arguments) {
  const auto& ellipsoids = *static_cast<const std::vector<Ellipsoid>*>(arguments->geometryUserPtr);
  const Ellipsoid& e = ellipsoids[arguments->primID];
  const Eigen::Vector3f low = (e.center - e.half_extents()).cast<float>();
  const Eigen::Vector3f high = (e.center + e.half_extents()).cast<float>();
  RTCBounds& b = *arguments->bounds_o;
  b.lower_x = std::nextafter(low[0], -kInfinity);
  b.lower_y = std::nextafter(low[1], -kInfinity);
  b.lower_z = std::nextafter(low[2], -kInfinity);
  b.upper_x = std::nextafter(high[0], kInfinity);
  b.upper_y = std::nextafter(high[1], kInfinity);
  b.upper_z = std::nextafter(high[2], kInfinity);
}

bool test_primitive(RTCPointQueryFunctionArguments* arguments) {
  static_cast<GoldenNarrowPhase::Query*>(arguments->userPtr)->test(arguments->primID);
  return false;  // the radius is unchanged
}

template <auto release>
struct Release {
  template <typename T>
  void operator()(T* handle) const {
    release(handle);
  }
};
using Device = std::unique_ptr<std::remove_pointer_t<RTCDevice>, Release<rtcReleaseDevice>>;
using Scene = std::unique_ptr<std::remove_pointer_t<RTCScene>, Release<rtcReleaseScene>>;
using Geometry = std::unique_ptr<std::remove_pointer_t<RTCGeometry>, Release<rtcReleaseGeometry>>;

class Embree final : public Pipeline {
 public:
  explicit Embree(const PipelineInput& input)
      : narrow_(input.ellipsoids), device_(rtcNewDevice(nullptr)), scene_(rtcNewScene(device_.get())) {
    const Geometry geometry(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_USER));
    const std::vector<Ellipsoid>& ellipsoids = narrow_.ellipsoids();
    rtcSetGeometryUserPrimitiveCount(geometry.get(), static_cast<unsigned>(ellipsoids.size()));
    rtcSetGeometryUserData(geometry.get(), const_cast<std::vector<Ellipsoid>*>(&ellipsoids));
    rtcSetGeometryBoundsFunction(
        geometry.get(), [](const RTCBoundsFunctionArguments* a) { ellipsoid_bounds(a); }, nullptr);
    rtcCommitGeometry(geometry.get());
    rtcAttachGeometry(scene_.get(), geometry.get());
    rtcCommitScene(scene_.get());
    if (const RTCError error = rtcGetDeviceError(device_.get()); error != RTC_ERROR_NONE) {
      throw Error("Embree: cannot build its scene (error {})", static_cast<int>(error));
    }
  }

  std::string name() const override { return "Embree point query"; }
  void query(const Ellipsoid& tool) override {
    GoldenNarrowPhase::Query query(narrow_, tool);
    const Eigen::Vector3f center = tool.center.cast<float>();
    RTCPointQuery sphere{center[0], center[1], center[2], 0.0F,
                         static_cast<float>(tool.radius() + kRounding)};
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene_.get(), &sphere, &context, test_primitive, &query);
  }
  void hits(std::vector<Hit>& out) const override { out = narrow_.hits(); }

 private:
  /// Bound of the rounding error of a coordinate in single precision, in a hall of 100 m. Unit: [m].
  static constexpr double kRounding = 1e-5;

  GoldenNarrowPhase narrow_;
  Device device_;
  Scene scene_;
};

}  // namespace

Pipelines build_embree(const PipelineInput& input) { return only<Embree>(input); }

}  // namespace palpate::bench
