/// \file
/// Passive change of a force model's gain under load.
#pragma once

namespace palpate {

/// Factor on a model's wrench with which a change of the gain does no work. A spring made g times as stiff
/// under load stores g times the energy, which the hand has not put in. Here the stored energy is preserved:
/// with S the energy in the model's spring, the wrench is the gradient of
///
///     U = (sqrt(g S) - c)^2        wrench = -dU/dx = g (1 - c / sqrt(g S)) (-dS/dx)
///
/// with c such that U is the same before and after g changes, and at most g S. The force changes by the
/// factor sqrt(g) at once and by g for further indentation, and c vanishes as the hand lets go.
///
/// Energy that enters the spring without work of the hand is excluded from U in the same way, as where a tool
/// is turned into a surface through a device without torque output.
///
/// One object per port and thread; does not allocate.
class PassiveGain {
 public:
  explicit PassiveGain(double gain) : gain_(gain) {}

  /// Factor for this tick. \param gain g, >= 0 \param stored S; NaN if unknown: the gain itself is then
  /// returned. Unit: [J]. \param given energy that has entered S since the last call without work of the
  /// hand; negative if it has left. Unit: [J].
  double at(double gain, double stored, double given = 0.0);

  /// U at the last call of at(). Unit: [J].
  double stored_energy() const { return root_ * root_; }

  /// Resets c to zero: no load.
  void reset() { lag_ = 0.0; }

 private:
  double gain_;
  double lag_ = 0.0;   ///< c. Unit: [J^(1/2)].
  double root_ = 0.0;  ///< of U
};

}  // namespace palpate
