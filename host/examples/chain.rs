//! scratch
use preslide::control::Settings;
use preslide_host::capture::{Scale, capture};
use preslide_host::chain;
use preslide_host::model::Model;
use preslide_host::stage::concealed::Concealed;
use std::path::Path;

fn main() -> anyhow::Result<()> {
    let a: Vec<String> = std::env::args().skip(1).collect();
    let seed: u64 = a[1].parse()?;
    let index: usize = a[2].parse()?;
    let folder = Path::new(&a[3]);
    let effect = Concealed::draw(seed, index + 1)[index];
    match a[0].as_str() {
        "record" => {
            std::fs::create_dir_all(folder)?;
            let bytes = chain::record(chain::stage(effect, seed + 100)?)?;
            let s = capture(
                &bytes[..],
                std::fs::File::create(folder.join("recording.csv"))?,
                &Scale::of(&Settings::PAPER_AXIS, 50),
                None,
                || {},
            )?;
            println!("{effect:?}\n{s:?}");
            std::fs::write(
                folder.join("known.toml"),
                chain::known(&effect)
                    .map_err(anyhow::Error::msg)?
                    .to_toml(&[]),
            )?;
        }
        "score" => {
            let stage = || chain::stage(effect, seed + 200);
            let none = chain::follow(stage()?, None)?;
            print!(
                "{} none {:.0}",
                effect.id(),
                none.rms_m().unwrap_or(f64::NAN) * 1e9
            );
            let mut rms = vec![];
            for name in ["model", "extended", "known"] {
                let model = Model::load(&folder.join(format!("{name}.toml")));
                let Ok(model) = model else {
                    rms.push(f64::NAN);
                    continue;
                };
                let t = chain::follow(stage()?, Some(&model))?;
                rms.push(t.rms_m().unwrap_or(f64::NAN) * 1e9);
                print!(" {name} {:.0}", rms[rms.len() - 1]);
            }
            println!("  ratio {:.2}", rms[1] / rms[2]);
        }
        _ => {}
    }
    Ok(())
}
