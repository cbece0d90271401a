// SimpleFOC: the friction of a joint as current feed-forward, with `motor.torque_controller = TorqueControlType::foc_current`.
// The model is of a rotary axis (q_rad, torque_Nm); loop() must run at the rate that it was exported for.
#include "simplefoc.h"
#include "joint_model.h"

static const float TORQUE_CONSTANT_NM_PER_A = 0.05f; // of your motor

static joint_model_state friction;
static float last_angle;

void friction_begin(const FOCMotor &motor)
{
    joint_model_rest(&friction);
    last_angle = motor.shaft_angle;
}

// In loop(), before motor.loopFOC() and motor.move(target).
void friction_update(FOCMotor &motor)
{
    const float moved = motor.shaft_angle - last_angle;
    last_angle = motor.shaft_angle;
    motor.feed_forward_current.q = joint_model_step(&friction, moved, motor.shaft_velocity) / TORQUE_CONSTANT_NM_PER_A;
}
