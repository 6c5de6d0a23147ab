/// \file
/// The force at one pose.
#pragma once

#include <palpate/collision/contact.h>
#include <palpate/geometry/pose.h>
#include <palpate/haptics/force_model.h>

namespace palpate {

/// Returns the output of `model` for a tool that starts at a pose and rests there, in steps of 1 ms, until
/// the model knows it and the wrench has not changed by more than 1e-9 N and N m for 50 steps; the output
/// after 300 steps where it never does so. A single evaluate() is not enough for ProxyForce: a proxy that
/// starts in contact takes some steps to view the scene around it and to come to the surface, and there is no
/// force until then. Models whose force depends only on pose, contacts and velocity return that of their
/// first step, as DensityForce does: its averages begin there.
///
/// Takes up to 300 times evaluate(), 0.2 s for ProxyForce on a slow computer. Starts with model.reset().
/// \param tool X_WT \param contacts of all parts of the tool at that pose; empty if the model wants none
ForceOutput settled_force(ForceModel& model, const Pose& tool, const ContactSet& contacts);

}  // namespace palpate
