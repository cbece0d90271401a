//! How long the code of a RISC-V program's functions is, with all that they can call.
//!
//! The testbench records no paths, so that what is counted is what a function can reach: cold branches and what they call as well.

use std::path::Path;

use anyhow::{Context as _, Result};
use preslide_tools::objdump::Functions;
use preslide_tools::process::{command, output};

pub struct Sizes(Functions);

impl Sizes {
    pub fn of(program: &Path) -> Result<Self> {
        let listing = output(command("riscv64-unknown-elf-objdump -d").arg(program))?;
        Ok(Self::parse(&listing))
    }

    fn parse(listing: &str) -> Self {
        Self(Functions::of(listing, |o| o.starts_with(['j', 'b'])))
    }

    /// Bytes of a function and of all that it can reach.
    pub fn reached_from(&self, name: &str) -> Result<u32> {
        let start = self.0.address(name);
        let start = start.with_context(|| format!("the program has no function {name}"))?;
        let reached = self.0.reached(start, &[]);
        Ok(reached.values().map(|function| function.bytes).sum())
    }
}

#[cfg(test)]
mod tests {
    use super::Sizes;

    #[test]
    fn a_function_counts_with_what_it_can_reach_once() {
        let listing = "\n20000000 <a>:\n20000000:\t00000097          \tauipc\tra,0x0\n20000004:\t008080e7          \tjalr\t8(ra) # 20000008 <b>\n\
                       \n20000008 <b>:\n\n20000008 <.L1>:\n20000008:\tdd7d                \tbeqz\ta0,20000000 <a+0x4>\n2000000a:\t8082                \tret\n\
                       \n2000000c <c>:\n2000000c:\t8082                \tret\n";
        let sizes = Sizes::parse(listing);
        assert_eq!(sizes.reached_from("a").unwrap(), 12);
        assert_eq!(sizes.reached_from("c").unwrap(), 2);
        assert!(sizes.reached_from("d").is_err());
    }
}
