//! HDF5, which MATLAB v7.3 files are too: the numeric vectors of all groups.

use hdf5_reader::error::Error;
use hdf5_reader::group::Group;
use hdf5_reader::{Dataset, Datatype, Hdf5File, OpenOptions};

use super::{Input, Variable, spend};

/// Groups within groups that are looked into.
const DEEPEST: usize = 8;

pub(super) fn variables(mut input: Input) -> Result<Vec<Variable>, String> {
    let bytes = input.bytes()?;
    let limit = usize::try_from(input.budget).unwrap_or(usize::MAX);
    let options = OpenOptions::default().with_max_read_bytes(limit);
    let file = Hdf5File::from_vec_with_options(bytes, options).map_err(broken)?;
    let root = file.root_group().map_err(broken)?;
    let mut found = Vec::new();
    collect(&root, "", DEEPEST, &mut input.budget, &mut found)?;
    Ok(found)
}

fn broken(e: Error) -> String {
    format!("an HDF5 file that cannot be read ({e}); copy or write it again")
}

fn collect(
    group: &Group,
    prefix: &str,
    deep: usize,
    budget: &mut u64,
    found: &mut Vec<Variable>,
) -> Result<(), String> {
    let (groups, sets) = group.members().map_err(broken)?;
    for set in &sets {
        found.push(variable(set, prefix, budget)?);
    }
    // MATLAB keeps what cells and structures refer to in groups of such names.
    let own = |g: &&Group| !g.name().starts_with('#');
    for inner in groups.iter().filter(own).filter(|_| deep > 0) {
        let prefix = format!("{prefix}{}/", inner.name());
        collect(inner, &prefix, deep - 1, budget, found)?;
    }
    Ok(())
}

fn variable(set: &Dataset, prefix: &str, budget: &mut u64) -> Result<Variable, String> {
    let name = format!("{prefix}{}", set.name());
    let dimensions: Vec<usize> = set.shape().iter().map(|&n| n as usize).collect();
    let class = set.attribute("MATLAB_class").ok();
    let class = class.and_then(|a| a.read_string().ok());
    let values = if class.is_some_and(|c| c == "char" || c == "cell") {
        Err("text")
    } else {
        let count = set.num_elements().map_err(broken)?;
        match numbers(set, &mut || spend(budget, count.saturating_mul(8))) {
            Some(values) => Ok(values?),
            None => Err("no numbers"),
        }
    };
    Ok(Variable {
        name,
        unit: None,
        dimensions,
        values,
    })
}

/// All numbers of a data set; `None` where they are none.
fn numbers(
    set: &Dataset,
    spend: &mut dyn FnMut() -> Result<(), String>,
) -> Option<Result<Vec<f64>, String>> {
    macro_rules! read {
        ($kind:ty) => {{
            let read = |()| {
                let array = set.read_array::<$kind>().map_err(broken)?;
                Ok(array.iter().map(|&v| v as f64).collect())
            };
            Some(spend().and_then(read))
        }};
    }
    match set.dtype() {
        Datatype::FloatingPoint { size: 8, .. } => read!(f64),
        Datatype::FloatingPoint { size: 4, .. } => read!(f32),
        Datatype::FixedPoint { size, signed, .. } => match (size, signed) {
            (1, true) => read!(i8),
            (2, true) => read!(i16),
            (4, true) => read!(i32),
            (8, true) => read!(i64),
            (1, false) => read!(u8),
            (2, false) => read!(u16),
            (4, false) => read!(u32),
            (8, false) => read!(u64),
            _ => None,
        },
        _ => None,
    }
}
