/// \file
/// The hand that holds a simulated device.
#pragma once

#include <atomic>

#include <palpate/device/simulated_device.h>
#include <palpate/gateway/client_hand.h>

namespace palpate {

/// Where the hand wants to be, in the device's frame: on its own way while `moves_itself` is set, on which
/// time stands still otherwise; where a client leads it, which clears `moves_itself`; and afterwards where
/// that has left it, until `moves_itself` is set again. With the tremor of a hand. The servo thread's; what
/// it is given must outlive it. \param own in the device's frame
HandPath simulated_hand(HandPath own, ClientHand& client, std::atomic<bool>& moves_itself);

}  // namespace palpate
