//! Errors of invalid figures, and consistency of the renderings.

use luenberger_figures::figure::{FigureError, interactive, still};
use luenberger_figures::{Bar, Figure, Mark, Panel, Series};

fn panel() -> Panel {
    Panel::new("time t (s)", "error e (m)")
}

fn refused(panel: Panel) -> FigureError {
    let figure = Figure::new("").panel(panel);
    let error = still::svg(&figure).unwrap_err();
    // Compared by message, because an error that contains NaN is not equal to itself.
    assert_eq!(still::png(&figure).unwrap_err().to_string(), error.to_string());
    assert_eq!(interactive::plotly(&figure).unwrap_err().to_string(), error.to_string());
    error
}

#[test]
fn what_cannot_be_drawn_is_an_error_that_names_it() {
    let line = |x: &[f64], y: &[f64]| Series::line("cubic", x, y);
    assert!(matches!(refused(panel()), FigureError::Empty { .. }));
    assert!(matches!(refused(panel().series(line(&[], &[]))), FigureError::Empty { what } if what.contains("cubic")));
    assert!(matches!(refused(panel().series(line(&[0.0], &[]))), FigureError::Length { x: 1, y: 0, .. }));
    assert!(matches!(
        refused(panel().series(line(&[0.0, 1.0], &[0.0, f64::NAN]))),
        FigureError::NotFinite { index: 1, .. }
    ));
    assert!(matches!(
        refused(panel().log_y().series(line(&[0.0, 1.0], &[0.0, 1.0]))),
        FigureError::NotPositive { index: 0, value: 0.0, .. }
    ));
    let two = || panel().series(line(&[0.0, 1.0], &[0.0, 1.0]));
    assert!(matches!(refused(two().y_range(1.0, 1.0)), FigureError::Range { axis: "vertical", .. }));
    assert!(matches!(refused(two().x_range(0.0, f64::INFINITY)), FigureError::Range { axis: "horizontal", .. }));
    assert!(matches!(refused(two().mark(Mark::horizontal(f64::NAN))), FigureError::NotFinite { .. }));
    assert!(matches!(
        refused(Panel::new("", "y").series(line(&[0.0], &[0.0]))),
        FigureError::Unlabelled { axis: "horizontal", panel: 0 }
    ));
    assert!(matches!(refused(panel().log_x().bar(Bar::to("margin", 0.0, "0"))), FigureError::NotPositive { .. }));
    assert!(matches!(
        refused(panel().series(line(&[0.0, 1.0], &[-f64::MAX, f64::MAX]))),
        FigureError::Range { axis: "vertical", .. }
    ));
    assert!(matches!(still::svg(&Figure::new("")).unwrap_err(), FigureError::Empty { .. }));
}

#[test]
fn one_point_and_constant_curves_can_be_drawn() {
    for y in [0.0, -3.0, 1e-300, 1e200] {
        let figure = Figure::new("").panel(panel().series(Series::line("a", &[1.0, 2.0], &[y, y])));
        still::svg(&figure).unwrap();
        interactive::plotly(&figure).unwrap();
    }
    still::png(&Figure::new("").panel(panel().series(Series::points("a", &[1.0], &[2.0])))).unwrap();
}

#[test]
fn the_renderings_share_names_labels_and_colours() {
    let x = [0.0, 1.0, 2.0];
    let figure =
        Figure::new("").panel(panel().series(Series::line("cubic", &x, &[3.0, 1.0, 0.5])).series(Series::line(
            "linear",
            &x,
            &[3.0, 2.0, 1.0],
        )));
    let svg = still::svg(&figure).unwrap();
    let plotly = interactive::plotly(&figure).unwrap().to_string();
    for word in ["cubic", "linear", "time t (s)", "error e (m)", "#0072b2", "#d55e00"] {
        assert!(svg.contains(word) && plotly.contains(word), "{word}");
    }
    assert!(svg.contains("stroke-dasharray") && plotly.contains("\"dash\":\"dash\""));
}

#[test]
fn curves_are_clipped_to_their_axes() {
    let x: Vec<f64> = (0..=100).map(|k| f64::from(k) / 10.0).collect();
    let y: Vec<f64> = x.iter().map(|x| (x * x).exp().min(1e30)).collect();
    let svg =
        still::svg(&Figure::new("").panel(panel().series(Series::line("blow-up", &x, &y)).y_range(0.0, 10.0))).unwrap();
    let paths: Vec<&str> = svg.split("<path d=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    assert!(!paths.is_empty());
    for number in
        paths.iter().flat_map(|path| path.split(|c: char| c == ' ' || c.is_alphabetic())).filter(|n| !n.is_empty())
    {
        let coordinate: f64 = number.parse().unwrap();
        assert!((0.0..=520.0).contains(&coordinate), "{coordinate} lies beyond the page");
    }
}
