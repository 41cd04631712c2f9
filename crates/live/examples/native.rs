//! The results of this machine for a page's experiment: from standard input `{"experiment": .., "sliders": [..]}`, to
//! standard output a list with outcome and verdicts of each position of the sliders, as texts.

use std::io::Read;

use luenberger_live::{Experiment, Sliders, run, verify};

#[derive(serde::Deserialize)]
struct Request {
    experiment: Experiment,
    sliders: Vec<Sliders>,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut text = String::new();
    std::io::stdin().read_to_string(&mut text)?;
    let Request { experiment, sliders } = serde_json::from_str(&text)?;
    let results = sliders.iter().map(|sliders| {
        let outcome = serde_json::to_string(&run(&experiment, sliders))?;
        Ok([outcome, serde_json::to_string(&verify(&experiment, sliders))?])
    });
    let results: Vec<[String; 2]> = results.collect::<Result<_, serde_json::Error>>()?;
    println!("{}", serde_json::to_string(&results)?);
    Ok(())
}
