#include <palpate/device/giant_mujoco.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <palpate/base/error.h>
#include <palpate/kinematics/chain_kinematics.h>

namespace palpate {
namespace {

/// Least mass and inertia of a body: MuJoCo rejects zero. Unit: [kg], [kg m^2].
constexpr double kLeastMass = 1e-6, kLeastInertia = 1e-8;

std::string vector_text(const Eigen::Vector3d& v) {
  return fmt::format("{:.17g} {:.17g} {:.17g}", v.x(), v.y(), v.z());
}

std::string pose_text(const Pose& pose) {
  const Eigen::Quaterniond& q = pose.orientation;
  return fmt::format(R"(pos="{}" quat="{:.17g} {:.17g} {:.17g} {:.17g}")", vector_text(pose.position), q.w(),
                     q.x(), q.y(), q.z());
}

std::string inertia_text(const LinkInertia& link) {
  const Eigen::Matrix3d I = link.inertia + kLeastInertia * Eigen::Matrix3d::Identity();
  return fmt::format(
      R"(<inertial pos="{}" mass="{:.17g}" fullinertia="{:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g}"/>)",
      vector_text(link.center), std::max(link.mass, kLeastMass), I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2),
      I(1, 2));
}

/// Dry friction is a constraint that yields slightly; as stiff as MuJoCo accepts.
std::string joint_text(const ChainJoint& joint, double viscous, double coulomb, double step) {
  return fmt::format(
      R"(<joint name="{}" type="{}" axis="{}" damping="{:.17g}" frictionloss="{:.17g}" solreffriction="{:.17g} 1" solimpfriction="0.9999 0.9999 0.001"/>)",
      joint.name, joint.type == JointType::kPrismatic ? "slide" : "hinge", vector_text(joint.axis), viscous,
      coulomb, 2.0 * step);
}

std::string model_text(const SerialChain& chain, const JointPlantFigures& figures, double bandwidth,
                       const GripProperties& grip) {
  std::string bodies, ends, actuators;
  for (int i = 0; i < chain.size(); ++i) {
    ChainJoint joint = chain.joints[static_cast<std::size_t>(i)];
    joint.name = fmt::format("j{}", i);  // names in the file may not be valid XML
    bodies += fmt::format("<body {}>{}{}", pose_text(joint.origin), inertia_text(joint.link),
                          joint_text(joint, figures.viscous[i], figures.coulomb[i], GiantMujoco::kStep));
    ends += "</body>";
    actuators += fmt::format(
        R"(<general joint="j{}" dyntype="filter" dynprm="{:.17g}" gainprm="{:.17g}" biastype="affine" biasprm="0 {:.17g} {:.17g}"/>)",
        i, 1.0 / bandwidth, figures.stiffness[i], -figures.stiffness[i], -figures.damping[i]);
  }
  LinkInertia hand;
  hand.mass = grip.hand.mass;
  hand.inertia = grip.gyration * grip.gyration * grip.hand.mass * Eigen::Matrix3d::Identity();
  bodies += fmt::format(R"(<body name="hand" {}>{}<site name="grip"/></body>)", pose_text(chain.tip),
                        inertia_text(hand));
  return fmt::format(R"(<mujoco>
<compiler angle="radian" balanceinertia="true"/>
<option integrator="RK4" solver="Newton" gravity="0 0 0" timestep="{}"><flag contact="disable"/></option>
<worldbody>{}{}</worldbody><actuator>{}</actuator>
<sensor><force site="grip"/><torque site="grip"/></sensor></mujoco>)",
                     GiantMujoco::kStep, bodies, ends, actuators);
}

mjModel* compiled(const SerialChain& chain, const std::string& xml) {
  constexpr const char* kName = "chain.xml";
  const auto files = std::make_unique<mjVFS>();  // two megabytes
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), kName, static_cast<int>(xml.size()));
  std::memcpy(files->filedata[0], xml.data(), xml.size());
  std::array<char, 1000> error{};
  mjModel* const model = mj_loadXML(kName, files.get(), error.data(), static_cast<int>(error.size()));
  mj_deleteVFS(files.get());
  if (model == nullptr) throw Error("{}: MuJoCo rejects this chain: {}", chain.name, error.data());
  return model;
}

Eigen::Map<const Eigen::Vector3d> at(const mjtNum* v) { return Eigen::Map<const Eigen::Vector3d>(v); }

}  // namespace

struct GiantMujoco::Simulation {
  struct Deleter {
    void operator()(mjModel* m) const { mj_deleteModel(m); }
    void operator()(mjData* d) const { mj_deleteData(d); }
  };
  explicit Simulation(mjModel* compiled_model)
      : model(compiled_model),
        data(mj_makeData(compiled_model)),
        hand(mj_name2id(compiled_model, mjOBJ_BODY, "hand")) {}

  Pose tip() const {
    const mjtNum* q = data->xquat + 4L * hand;
    return {at(data->xpos + 3L * hand), Eigen::Quaterniond(q[0], q[1], q[2], q[3])};
  }
  /// Velocity of the hand's body about its origin, world frame.
  Vector6d tip_velocity() const {
    std::array<mjtNum, 6> v{};  // angular first
    mj_objectVelocity(model.get(), data.get(), mjOBJ_BODY, hand, v.data(), 0);
    Vector6d result;
    result << v[3], v[4], v[5], v[0], v[1], v[2];
    return result;
  }

  std::unique_ptr<mjModel, Deleter> model;
  std::unique_ptr<mjData, Deleter> data;
  int hand;
  bool broken = false;
};

GiantMujoco::GiantMujoco(const SerialChain& chain, const JointPlantProperties& properties,
                         const GripProperties& grip, HandPath path)
    : bandwidth_(properties.bandwidth),
      figures_(chain, properties),
      grip_(grip),
      path_(std::move(path)),
      simulation_(
          std::make_unique<Simulation>(compiled(chain, model_text(chain, figures_, bandwidth_, grip)))) {
  mju_user_warning = [](const char*) {};  // no log file; advance() checks for warnings
  start(ChainLimits(chain).rest, 0.0);
}

GiantMujoco::~GiantMujoco() = default;

void GiantMujoco::start(const JointVector& q, double t) {
  mjData* const data = simulation_->data.get();
  mj_resetData(simulation_->model.get(), data);
  std::copy_n(q.data(), q.size(), data->qpos);
  std::copy_n(q.data(), q.size(), data->act);
  data->time = t;
  mj_forward(simulation_->model.get(), data);
  wanted_ = path_(t);
  tell();
}

void GiantMujoco::step(const JointVector& command) {
  mjData* const data = simulation_->data.get();
  const double h = simulation_->model->opt.timestep;
  const Pose wanted = path_(data->time + h), is = simulation_->tip();
  const Vector6d hand_velocity = difference(wanted_, wanted) / h;
  const HandProperties& hand = grip_.hand;
  Vector6d force =
      hand.stiffness * difference(is, wanted_) + hand.damping * (hand_velocity - simulation_->tip_velocity());
  force.tail<3>() *= grip_.gyration * grip_.gyration;
  std::copy_n(force.data(), 6, data->xfrc_applied + 6L * simulation_->hand);
  for (int i = 0; i < command.size(); ++i) {
    data->ctrl[i] = command[i];
    // Drive-side force of the damper between drive and joint; averaged over the step, as it decays.
    const double fall = -std::expm1(-bandwidth_ * h) / h;
    data->qfrc_applied[i] = figures_.damping[i] * fall * (command[i] - data->act[i]);
  }
  mj_step(simulation_->model.get(), data);
  wanted_ = wanted;
}

void GiantMujoco::advance(double until, const JointVector& command) {
  mjData* const data = simulation_->data.get();
  const auto steps = static_cast<int>(std::ceil((until - data->time) / kStep - 1e-6));
  if (steps <= 0 || simulation_->broken) return;
  simulation_->model->opt.timestep = (until - data->time) / steps;
  for (int k = 0; k < steps; ++k) step(command);
  data->time = until;  // exactly, without rounding
  for (const mjWarningStat& warning : data->warning)
    simulation_->broken = simulation_->broken || warning.number > 0;
  if (simulation_->broken) return;
  mj_forward(simulation_->model.get(), data);  // positions and sensors at this time, not one step ago
  tell();
}

void GiantMujoco::tell() {
  q_ = Eigen::Map<const Eigen::VectorXd>(simulation_->data->qpos, simulation_->model->nq);
}

Wrench GiantMujoco::hand() const {
  // MuJoCo reports the wrench of the last link on the hand, along the axes of the site.
  const Eigen::Quaterniond R = simulation_->tip().orientation;
  const mjtNum* s = simulation_->data->sensordata;
  return {-(R * at(s)), -(R * at(s + 3))};
}

}  // namespace palpate
