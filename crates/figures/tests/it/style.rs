//! The looks of series.

use luenberger_figures::internals::{CIVIDIS, GREY, resolve};
use luenberger_figures::{Figure, Hue, Panel, Series};

#[test]
fn a_name_has_one_look_in_the_whole_figure_and_no_two_share_one() {
    let line = |name: &str| Series::line(name, &[0.0], &[0.0]);
    let figure = Figure::new("")
        .panel(Panel::new("x", "y").series(line("a")).series(line("")).series(line("b")))
        .panel(Panel::new("x", "y").series(line("b")).series(line("c")));
    let looks = resolve(&figure);
    assert_eq!(looks[0][2], looks[1][0]);
    let (a, b, c) = (looks[0][0], looks[0][2], looks[1][1]);
    assert!(a.rgb != b.rgb && b.rgb != c.rgb && a.rgb != c.rgb);
    assert!(a.dash != b.dash && b.dash != c.dash && a.dash != c.dash);
    assert_eq!(looks[0][1].rgb, GREY);
}

#[test]
fn the_ramp_meets_its_ends_and_survives_what_lies_beyond() {
    let rgb = |share: f64| {
        let series = Series::line("", &[0.0], &[0.0]).hue(Hue::Ramp(share));
        resolve(&Figure::new("").panel(Panel::new("x", "y").series(series)))[0][0].rgb
    };
    assert_eq!([0.0, 1.0, 7.0, 0.5].map(rgb), [CIVIDIS[0], CIVIDIS[8], CIVIDIS[8], CIVIDIS[4]]);
}
