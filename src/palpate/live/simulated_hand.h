/// \file
/// Motion of the simulated hand that holds a simulated device.
#pragma once

#include <atomic>

#include <palpate/device/simulated_device.h>
#include <palpate/gateway/client_hand.h>

namespace palpate {

/// Returns the target path of the hand, in the device's frame. While `moves_itself` is set the hand follows
/// its path `own`, whose time stops otherwise. A client that leads the hand clears `moves_itself`; afterwards
/// the hand stays where it was left, until `moves_itself` is set again. Hand tremor is added. Used on the
/// servo thread; the arguments must outlive it. \param own in the device's frame
HandPath simulated_hand(HandPath own, ClientHand& client, std::atomic<bool>& moves_itself);

}  // namespace palpate
