/* A model that `preslide export --lang c` wrote (exported/NAME.c, included before this), called as the other kernels are and for no cycle more:
 * NAME begins its names, NUMBER is what it computes with, STEP is the function that src/exported.rs calls. The compiler is told that nothing else is (-fwhole-program). */

#define JOINED(name, part) name##part
#define OWN(name, part) JOINED(name, part)
#define CALLED __attribute__((externally_visible))

CALLED void OWN(NAME, _rest)(OWN(NAME, _state) *);

/* Of what it remembers. */
CALLED const uint32_t OWN(NAME, _bytes) = sizeof(OWN(NAME, _state));

CALLED NUMBER STEP(const void *model, OWN(NAME, _state) *state, NUMBER displacement, NUMBER velocity)
{
    (void)model;
    return OWN(NAME, _step)(state, displacement, velocity);
}
