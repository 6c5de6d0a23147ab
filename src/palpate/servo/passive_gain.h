/// \file
/// A spring that is changed while a hand leans on it.
#pragma once

namespace palpate {

/// What a model's wrench is multiplied with so that a change of the gain does no work. A spring that is made
/// g times as stiff under a hand holds g times the energy, which the hand has not put in. Here the hand keeps
/// what it has: with S the energy in the model's spring, the wrench is the gradient of
///
///     U = (sqrt(g S) - c)^2        wrench = -dU/dx = g (1 - c / sqrt(g S)) (-dS/dx)
///
/// with c such that U is the same before and after g has changed, and no more than g S. The force is then
/// sqrt(g) times what it was at once, g times for what is pressed further, and c goes as the hand lets go.
///
/// What winds the spring up without the hand's work is left out of U in the same way: a tool that is turned
/// into a surface through a device that shows no torque.
///
/// One object a port and thread; takes nothing from the heap.
class PassiveGain {
 public:
  explicit PassiveGain(double gain) : gain_(gain) {}

  /// What to multiply with at this tick. \param gain g, >= 0 \param stored S; NaN where nobody knows: the
  /// gain itself is told. Unit: [J]. \param given what has gone into S since the last call, and was not the
  /// hand's; negative where it has come out. Unit: [J].
  double at(double gain, double stored, double given = 0.0);

  /// U at the last call of at(). Unit: [J].
  double stored_energy() const { return root_ * root_; }

  /// Nothing is pressed.
  void reset() { lag_ = 0.0; }

 private:
  double gain_;
  double lag_ = 0.0;   ///< c. Unit: [J^(1/2)].
  double root_ = 0.0;  ///< of U
};

}  // namespace palpate
