/* Of LinuxCNC 2.9 (hal.h, rtapi_app.h): what the example takes. */
#ifndef LINUXCNC_INTERFACE_H
#define LINUXCNC_INTERFACE_H

typedef volatile double hal_float_t;
typedef enum { HAL_IN = 16, HAL_OUT = 32 } hal_pin_dir_t;

int hal_init(const char *name);
int hal_ready(int comp_id);
int hal_exit(int comp_id);
void *hal_malloc(long size);
int hal_pin_float_newf(hal_pin_dir_t dir, hal_float_t **data, int comp_id, const char *format, ...);
int hal_export_funct(const char *name, void (*funct)(void *, long), void *arg, int uses_fp, int reentrant, int comp_id);
int rtapi_app_main(void);
void rtapi_app_exit(void);

#endif
