// Of ros2_control (controller_interface, hardware_interface): the shape of what the example takes, without rclcpp.
#ifndef ROS2_CONTROL_INTERFACE_HPP
#define ROS2_CONTROL_INTERFACE_HPP

#include <vector>

namespace controller_interface {

enum class return_type { OK, ERROR };

struct LoanedInterface {
    double value;
    double get_value() const { return value; }
    void set_value(double next) { value = next; }
};

class ControllerInterface {
  public:
    virtual ~ControllerInterface() = default;
    virtual return_type update() = 0;

  protected:
    std::vector<LoanedInterface> command_interfaces_;
    std::vector<LoanedInterface> state_interfaces_;
};

} // namespace controller_interface

#endif
