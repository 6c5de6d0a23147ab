/// \file
/// Values as they are written on the command line and in configuration files.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include <palpate/device/simulated_device.h>

namespace palpate {

/// Thrown for a value that a setting does not accept; what() says why, without the setting's name.
class BadValue : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// \throws BadValue.
/// @{
double parse_number(std::string_view text);      ///< finite
double parse_positive(const std::string& text);  ///< finite and above zero
/// "1,2,3": between `min_count` and `max_count` finite numbers.
std::vector<double> parse_numbers(std::string_view text, std::size_t min_count, std::size_t max_count);
Eigen::Quaterniond parse_quaternion(const double* wxyz);  ///< normalized
HandProperties parse_hand(const double* mbk);             ///< kg, N s/m and N/m, none below zero
/// @}

/// \name The numbers of a value, as written
/// @{
inline std::vector<double> numbers(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
inline std::vector<double> numbers(const Eigen::Quaterniond& q) { return {q.w(), q.x(), q.y(), q.z()}; }
/// @}

/// \name Bounds on given numbers, within which every product of the contact mathematics is finite
/// @{
inline constexpr double kCoordinateMax = 1e9;  ///< Unit: [m].
inline constexpr double kQuaternionMax = 1e6;  ///< of a component, before normalization
/// @}

}  // namespace palpate
