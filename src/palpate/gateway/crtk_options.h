/// \file
/// Options of a CRTK device as text, as they follow `--device ros1:` or `ros2:`.
#pragma once

#include <string>

#include <palpate/gateway/crtk_device.h>

namespace palpate {

/// Which device, and what is known of it.
struct CrtkArguments {
  std::string prefix;  ///< of its topics: "/omni" for /omni/measured_cp
  CrtkOptions options;
};

/// From "/omni,force_max=3.3,rate=500": a prefix, then any of
///
///     force_max, force_sustained  N (default 3.3, the weakest device that is sold; the same for ever)
///     torque_max                  N m (0: it has no motors for the orientation)
///     stiffness_max, damping      N/m and N s/m (0: not known)
///     workspace                   m
///     rate                        Hz, of its poses at least (1000)
///     frame                       frame_id of its poses (that of the first)
///     delay                       s, from a wrench that has arrived until the motors show it (0)
///     one_way                     s, of the network, where no echo is answered (0.0005)
///     extrapolation               s, at most 0.01 (0: none)
///
/// \param kind "ros1": for messages \throws Error that names what is wrong.
CrtkArguments parse_crtk_arguments(const std::string& kind, const std::string& text);

}  // namespace palpate
