// Forward kinematics, Jacobian and inertia against KDL.
#include <palpate/kinematics/chain_kinematics.h>

#include <gtest/gtest.h>
#include <kdl/chaindynparam.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainidsolver_recursive_newton_euler.hpp>
#include <kdl/chainjnttojacsolver.hpp>

#include <palpate/kinematics/chain_file.h>
#include <support/kdl_chain.h>
#include <support/random_joints.h>

namespace palpate {
namespace {

constexpr int kPostures = 1000;

/// Joints about and along skew axes, with tilted inertias: what a gantry has not.
SerialChain skew_chain(std::mt19937_64& random) {
  SerialChain chain;
  chain.name = "skew";
  const auto direction = [&] {
    const Eigen::Vector3d v{test::uniform(random, -1, 1), test::uniform(random, -1, 1),
                            test::uniform(random, 0.1, 1)};
    return Eigen::Vector3d(v.normalized());
  };
  for (int i = 0; i < 7; ++i) {
    ChainJoint joint;
    joint.name = "j" + std::to_string(i);
    joint.type = i % 3 == 1 ? JointType::kPrismatic : JointType::kRevolute;
    joint.axis = direction();
    joint.origin.position = 0.5 * direction();
    joint.origin.orientation = Eigen::AngleAxisd{test::uniform(random, -3, 3), direction()};
    joint.limits = {-2.0, 2.0, 3.0, 20.0, 1e4};
    joint.link.mass = test::uniform(random, 0.5, 5.0);
    joint.link.center = 0.1 * direction();
    const Eigen::Matrix3d R = Eigen::AngleAxisd(1.0, direction()).toRotationMatrix();
    joint.link.inertia = R * Eigen::Vector3d(0.02, 0.03, 0.04).asDiagonal() * R.transpose();
    chain.joints.push_back(joint);
  }
  chain.tip.position = direction();
  chain.tip.orientation = Eigen::AngleAxisd(0.7, direction());
  check_chain(chain, "skew");
  return chain;
}

class AgainstKdl : public testing::TestWithParam<bool> {
 protected:
  AgainstKdl() : chain_(GetParam() ? giant_chain() : skew_chain(random_)), kdl_(test::kdl(chain_)) {}
  void draw() {
    q_ = test::posture(ChainLimits(chain_), random_);
    ours_.set(q_);
    theirs_.data = q_;
  }

  std::mt19937_64 random_{3};
  SerialChain chain_;
  KDL::Chain kdl_;
  ChainKinematics ours_{chain_};
  JointVector q_;
  KDL::JntArray theirs_{static_cast<unsigned>(chain_.size())};
};

TEST_P(AgainstKdl, ForwardKinematics) {
  KDL::ChainFkSolverPos_recursive solver(kdl_);
  for (int k = 0; k < kPostures; ++k) {
    draw();
    KDL::Frame frame;
    ASSERT_EQ(solver.JntToCart(theirs_, frame), 0);
    ASSERT_LT(difference(ours_.tip(), test::pose(frame)).norm(), 1e-12);
  }
}

TEST_P(AgainstKdl, Jacobian) {
  KDL::ChainJntToJacSolver solver(kdl_);
  KDL::Jacobian J(static_cast<unsigned>(chain_.size()));
  for (int k = 0; k < kPostures; ++k) {
    draw();
    ASSERT_EQ(solver.JntToJac(theirs_, J), 0);
    ASSERT_LT((ours_.jacobian() - J.data).norm(), 1e-12);
  }
}

TEST_P(AgainstKdl, Inertia) {
  KDL::ChainDynParam solver(kdl_, KDL::Vector::Zero());
  KDL::JntSpaceInertiaMatrix M(static_cast<unsigned>(chain_.size()));
  for (int k = 0; k < kPostures; ++k) {
    draw();
    ASSERT_EQ(solver.JntToMass(theirs_, M), 0);
    ASSERT_LT((ours_.inertia() - M.data).norm(), 1e-10 * M.data.norm());
  }
}

TEST_P(AgainstKdl, NoPostureNeedsMoreThanTheEffortForTheAccelerationsThatAreLeft) {
  for (ChainJoint& joint : chain_.joints) joint.limits.effort = 200.0;
  const JointVector kept = limit_by_effort(chain_, 0.5);
  EXPECT_LT(kept.maxCoeff(), 1.0);
  const ChainLimits limits(chain_);
  KDL::Chain loaded = test::kdl(chain_);
  loaded.addSegment(
      KDL::Segment(KDL::Joint(KDL::Joint::None), KDL::Frame::Identity(), KDL::RigidBodyInertia(0.5)));
  KDL::ChainIdSolver_RNE solver(loaded, KDL::Vector::Zero());
  const auto n = static_cast<unsigned>(chain_.size());
  KDL::JntArray rest(n), ddq(n), torques(n);
  const KDL::Wrenches none(loaded.getNrOfSegments(), KDL::Wrench::Zero());
  for (int k = 0; k < kPostures; ++k) {
    draw();
    for (Eigen::Index i = 0; i < q_.size(); ++i)
      ddq.data[i] = (random_() & 1U) != 0U ? limits.acceleration[i] : -limits.acceleration[i];
    ASSERT_EQ(solver.CartToJnt(theirs_, rest, ddq, none, torques), 0);
    ASSERT_LE(torques.data.cwiseAbs().maxCoeff(), 200.0);
  }
}

INSTANTIATE_TEST_SUITE_P(Chains, AgainstKdl, testing::Bool(),
                         [](const auto& info) { return info.param ? "Giant" : "Skew"; });

// The figures of the built-in device were chosen so that its motors have what its accelerations need.
TEST(GiantChain, HasTheEffortForItsAccelerations) {
  SerialChain chain = giant_chain();
  EXPECT_EQ(limit_by_effort(chain, 0.5).minCoeff(), 1.0);
}

}  // namespace
}  // namespace palpate
