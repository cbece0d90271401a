// ros2_control: an effort controller's friction compensation. State interfaces: position (rad) and velocity (rad/s) of one joint; command
// interface: its effort (N·m). A real controller takes the time and period in `update` and adds the lifecycle's callbacks.
#include "ros2_control.hpp"
#include "joint_model.h"

class FrictionCompensation : public controller_interface::ControllerInterface {
  public:
    FrictionCompensation() { joint_model_rest(&model_); }

    controller_interface::return_type update() override
    {
        if (state_interfaces_.size() < 2 || command_interfaces_.empty()) {
            return controller_interface::return_type::ERROR;
        }
        const double position = state_interfaces_[0].get_value();
        const double moved = begun_ ? position - last_ : 0.0;
        begun_ = true;
        last_ = position;
        const auto velocity = static_cast<float>(state_interfaces_[1].get_value());
        const float friction = joint_model_step(&model_, static_cast<float>(moved), velocity);
        command_interfaces_[0].set_value(effort_ + static_cast<double>(friction));
        return controller_interface::return_type::OK;
    }

    // What the rest of the controller asks for (N·m).
    void set_effort(double effort) { effort_ = effort; }

  private:
    joint_model_state model_{};
    double last_ = 0.0;
    double effort_ = 0.0;
    bool begun_ = false;
};

// The plugin's registration stands in its place: PLUGINLIB_EXPORT_CLASS(FrictionCompensation, ...).
controller_interface::ControllerInterface *make_friction_compensation() { return new FrictionCompensation(); }
