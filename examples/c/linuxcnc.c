/* LinuxCNC: a realtime HAL component. Add it to the servo thread behind the planner and before the PID's output goes to the drive:

     loadrt friction
     addf friction.0 servo-thread
     net xcmd    joint.0.motor-pos-cmd => friction.0.position    (metres: scale if your machine's unit is mm)
     net xvel    joint.0.vel-cmd       => friction.0.velocity
     net xff     friction.0.force      => sum2.0.in1             (in0: pid.x.output; sum2.0.out: the drive)

   The servo thread must run at the rate that the model was exported for. */
#include "linuxcnc.h"
#include "stage_model.h"

typedef struct {
    hal_float_t *position;
    hal_float_t *velocity;
    hal_float_t *force;
    double last;
    int begun;
    stage_model_state model;
} friction_t;

static int component;

static void update(void *arg, long period_ns)
{
    friction_t *axis = arg;
    const double position = *axis->position;
    (void)period_ns;
    if (!axis->begun) {
        axis->last = position;
        axis->begun = 1;
    }
    /* The difference in double precision, then single: nanometres at the end of a metre. */
    *axis->force = (double)stage_model_step(&axis->model, (float)(position - axis->last), (float)*axis->velocity);
    axis->last = position;
}

int rtapi_app_main(void)
{
    friction_t *axis;
    component = hal_init("friction");
    if (component < 0) {
        return component;
    }
    axis = hal_malloc((long)sizeof *axis);
    if (axis == 0 || hal_pin_float_newf(HAL_IN, &axis->position, component, "friction.0.position") != 0
        || hal_pin_float_newf(HAL_IN, &axis->velocity, component, "friction.0.velocity") != 0
        || hal_pin_float_newf(HAL_OUT, &axis->force, component, "friction.0.force") != 0
        || hal_export_funct("friction.0", update, axis, 1, 0, component) != 0) {
        hal_exit(component);
        return -1;
    }
    axis->begun = 0;
    stage_model_rest(&axis->model);
    return hal_ready(component);
}

void rtapi_app_exit(void)
{
    hal_exit(component);
}
