/* Of SimpleFOC 2.4 (Arduino-FOC, src/common/base_classes/FOCMotor.h): what the example takes. */
#ifndef SIMPLEFOC_INTERFACE_H
#define SIMPLEFOC_INTERFACE_H

struct DQCurrent_s {
    float d;
    float q;
};

class FOCMotor {
  public:
    virtual ~FOCMotor() {}
    virtual void loopFOC() = 0;
    virtual void move(float target) = 0;
    float shaft_angle;
    float shaft_velocity;
    DQCurrent_s feed_forward_current;
};

#endif
