// Runs a program on the verilated core: memory that answers in the next cycle on both ports, a console, an end.
//
// bench IMAGE [FETCH DATA]: a flat binary, loaded where the core begins. A byte stored to CONSOLE is printed; a word stored to END ends
// the run with that exit code. The program counts its cycles itself (mcycle). FETCH and DATA are wait states of every access to
// instructions and to data; with them the word at BRIEF is 1.

#include "Vrp2350.h"
#include "verilated.h"

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <vector>

static const uint32_t BASE = 0x20000000, SIZE = 4 << 20; // more than the RP2350's 520 KiB: the image holds every kernel
static const uint32_t CONSOLE = 0xf0000000, END = 0xf0000004, BRIEF = 0xf0000008;
static const uint64_t LIMIT = 20'000'000'000;

static std::vector<uint8_t> memory(SIZE + 4);

static uint32_t word(uint32_t address)
{
	uint32_t at = (address & ~3u) - BASE;
	if (at >= SIZE)
		return 0;
	return memory[at] | memory[at + 1] << 8 | memory[at + 2] << 16 | (uint32_t)memory[at + 3] << 24;
}

struct Access {
	bool active, write;
	uint32_t address, size;
	int waits; // cycles until it is answered
};

int main(int count, char **arguments)
{
	if (count != 2 && count != 4) {
		fprintf(stderr, "usage: bench IMAGE [FETCH DATA]\n");
		return 2;
	}
	const bool brief = count == 4;
	const int fetch_waits = brief ? atoi(arguments[2]) : 0, data_waits = brief ? atoi(arguments[3]) : 0;
	std::ifstream file(arguments[1], std::ios::binary);
	std::vector<char> image((std::istreambuf_iterator<char>(file)), {});
	if (!file.is_open() || image.empty() || image.size() > SIZE) {
		fprintf(stderr, "bench: %s is missing, empty or larger than the memory\n", arguments[1]);
		return 2;
	}
	std::copy(image.begin(), image.end(), memory.begin());

	Vrp2350 core;
	Access fetch = {}, data = {};
	for (uint64_t cycle = 0; cycle < LIMIT; cycle++) {
		core.rst_n = cycle >= 4;
		core.i_hready = fetch.waits == 0;
		core.d_hready = data.waits == 0;
		core.i_hrdata = fetch.active ? word(fetch.address) : 0;
		core.d_hrdata = !data.active || data.write ? 0 : data.address == BRIEF ? brief : word(data.address);
		core.clk = 0;
		core.eval();
		if (data.active && data.write && core.d_hready) {
			uint32_t value = core.d_hwdata >> 8 * (data.address & 3);
			if (data.address == CONSOLE) {
				putchar(value & 0xff);
			} else if (data.address == END) {
				fflush(stdout);
				fprintf(stderr, "bench: %llu cycles\n", (unsigned long long)cycle);
				return (int)value;
			} else if (data.address - BASE < SIZE) {
				for (uint32_t byte = 0; byte < 1u << data.size; byte++)
					memory[data.address - BASE + byte] = value >> 8 * byte;
			} else {
				fprintf(stderr, "bench: a store to %#x, where nothing is\n", data.address);
				return 1;
			}
		}
		if (!core.i_hready)
			fetch.waits--;
		else if (core.i_htrans & 2)
			fetch = {true, false, core.i_haddr, 2, fetch_waits};
		else
			fetch = {};
		if (!core.d_hready)
			data.waits--;
		else if (core.d_htrans & 2)
			data = {true, core.d_hwrite != 0, core.d_haddr, core.d_hsize, data_waits};
		else
			data = {};
		core.clk = 1;
		core.eval();
	}
	fprintf(stderr, "bench: the program did not end within %llu cycles\n", (unsigned long long)LIMIT);
	return 1;
}
