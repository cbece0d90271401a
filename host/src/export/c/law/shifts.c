/* Does not compile where a shift of a negative number is none that rounds down. */
typedef char @shifts_round_down[(-1 >> 1) == -1 ? 1 : -1];
