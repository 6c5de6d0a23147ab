/// \file
/// 3D Gaussian splatting scene, as stored in its file.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace palpate {

/// How the stored numbers encode standard deviations and opacities.
enum class ScaleEncoding {
  kLog,     ///< sigma = exp(scale), as INRIA trains it
  kLinear,  ///< sigma = |scale|
};
enum class OpacityEncoding {
  kLogit,  ///< alpha = 1 / (1 + exp(-opacity)), as INRIA trains it
  kByte,   ///< alpha = opacity / 255
};

/// One Gaussian in the captured frame, activated, in double precision. Sigma and rotation are paper eq. 2:
/// Sigma = R diag(sigma)^2 R^T. May hold NaN or infinities if the file does (see defect()).
struct Gaussian {
  Eigen::Vector3d position;     ///< mean mu, in captured units
  Eigen::Quaterniond rotation;  ///< unit norm; NaN if the file's quaternion is zero
  Eigen::Vector3d sigma;        ///< standard deviations along the rotated axes, captured units
  double opacity;               ///< alpha in [0, 1]
};

/// Gaussians as a structure of arrays, all of one length (colour and filter_3d may be empty).
/// The arrays hold the file's own single-precision numbers, not activated ones, so that nothing is
/// rounded between the file and the contact: gaussian() activates one in double precision.
struct GaussianScene {
  std::string source;  ///< file name, for messages
  std::string format;  ///< e.g. "INRIA .ply, binary_little_endian, SH degree 3"
  ScaleEncoding scale_encoding = ScaleEncoding::kLog;
  OpacityEncoding opacity_encoding = OpacityEncoding::kLogit;
  int sh_degree = 0;                 ///< of the view-dependent colour in the file
  std::uint64_t trailing_bytes = 0;  ///< unexplained bytes after the data

  /// Offset added to every position. Zero unless the file holds double-precision positions that single
  /// precision cannot represent, as georeferenced scenes do.
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();

  std::vector<std::uint32_t> id;                   ///< 0-based row in the file, strictly increasing
  std::vector<Eigen::Vector3f> position;           ///< relative to origin
  std::vector<Eigen::Vector3f> scale;              ///< by scale_encoding; a 2DGS disc has a zero sigma z
  std::vector<Eigen::Vector4f> rotation;           ///< quaternion w, x, y, z, not normalised
  std::vector<float> opacity;                      ///< by opacity_encoding
  std::vector<float> filter_3d;                    ///< Mip-Splatting's 3D filter, captured units; or empty
  std::vector<std::array<std::uint8_t, 3>> color;  ///< sRGB of the SH constant term; or empty

  std::size_t size() const { return position.size(); }

  /// Gaussian number `i` (not its id), activated. With Mip-Splatting's filter f, its eqs. apply:
  /// sigma' = sqrt(sigma^2 + f^2) and alpha' = alpha * prod(sigma / sigma').
  Gaussian gaussian(std::size_t i) const;

  /// Appends a Gaussian, encoded as kLog and kLogit, with the next id. \pre the scene uses these encodings,
  /// has a colour for each Gaussian, and neither origin nor filter
  void append(const Gaussian& activated, const std::array<std::uint8_t, 3>& rgb);

  /// Reserves capacity in all arrays; memory that stays unused is never touched.
  void reserve(std::size_t n);
};

/// Why a Gaussian cannot collide, independently of the filter.
enum class Defect {
  kNone,
  kNan,             ///< NaN in position, scale, rotation, opacity or filter
  kInfinite,        ///< infinite, or so large that it overflows: position or sigma beyond 1e12 units
  kZeroQuaternion,  ///< a quaternion of norm zero has no orientation
  kZeroScale,       ///< all three sigmas are zero: a point has no surface to touch
};
inline constexpr std::size_t kDefectCount = 5;

/// The word used for a defect in reports ("nan", "infinite", ...).
const char* to_string(Defect defect);

/// Largest valid coordinate or sigma, in captured units and in metres. Keeps every product of the contact
/// mathematics (sixth powers of size ratios) within the range of a double.
inline constexpr double kMaxExtent = 1e12;

/// The defect of Gaussian `i`, the first that applies in the order of the enumeration.
/// Opacity of +/-infinity is legal: it is the logit of exactly 1 or 0.
Defect defect(const GaussianScene& scene, std::size_t i);

/// The same, for a caller that already has `activated` = scene.gaussian(i).
Defect defect(const GaussianScene& scene, std::size_t i, const Gaussian& activated);

}  // namespace palpate
