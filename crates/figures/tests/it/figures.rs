//! Errors of invalid figures, and consistency of the renderings.

use luenberger_figures::figure::{FigureError, interactive, static_figure};
use luenberger_figures::{Area, Bar, Figure, Hue, Mark, Panel, Series};

fn panel() -> Panel {
    Panel::new("time t (s)", "error e (m)")
}

fn refused(panel: Panel) -> FigureError {
    let figure = Figure::new("").panel(panel);
    let error = static_figure::svg(&figure).unwrap_err();
    // Compared by message, because an error that contains NaN is not equal to itself.
    assert_eq!(static_figure::png(&figure).unwrap_err().to_string(), error.to_string());
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
    let band = |low: &[f64], high: &[f64]| two().area(Area::between("band", &[0.0, 1.0], low, high));
    assert!(matches!(refused(band(&[0.0], &[1.0, 1.0])), FigureError::Length { x: 2, y: 1, .. }));
    assert!(matches!(refused(band(&[0.0, f64::NAN], &[1.0, 1.0])), FigureError::NotFinite { index: 1, .. }));
    assert!(matches!(refused(band(&[0.0, 0.0], &[1.0, 1.0]).log_y()), FigureError::NotPositive { .. }));
    assert!(matches!(refused(two().area(Area::between("band", &[], &[], &[]))), FigureError::Empty { .. }));
    assert!(matches!(static_figure::svg(&Figure::new("")).unwrap_err(), FigureError::Empty { .. }));
}

#[test]
fn one_point_and_constant_curves_can_be_drawn() {
    for y in [0.0, -3.0, 1e-300, 1e200] {
        let figure = Figure::new("").panel(panel().series(Series::line("a", &[1.0, 2.0], &[y, y])));
        static_figure::svg(&figure).unwrap();
        interactive::plotly(&figure).unwrap();
    }
    static_figure::png(&Figure::new("").panel(panel().series(Series::points("a", &[1.0], &[2.0])))).unwrap();
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
    let svg = static_figure::svg(&figure).unwrap();
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
        static_figure::svg(&Figure::new("").panel(panel().series(Series::line("blow-up", &x, &y)).y_range(0.0, 10.0)))
            .unwrap();
    let paths: Vec<&str> = svg.split("<path d=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    assert!(!paths.is_empty());
    for number in
        paths.iter().flat_map(|path| path.split(|c: char| c == ' ' || c.is_alphabetic())).filter(|n| !n.is_empty())
    {
        let coordinate: f64 = number.parse().unwrap();
        assert!((0.0..=520.0).contains(&coordinate), "{coordinate} lies beyond the page");
    }
}

/// A shaded band: one closed path of the colour of its curve, within the axes, which the axis encloses; in the legend.
#[test]
fn areas_are_translucent_and_enclosed_by_the_axes() {
    let x = [0.0, 1.0, 2.0];
    let band = Area::between("filter \u{b1} 2 sigma", &x, &[-9.0, -2.0, -1.0], &[9.0, 2.0, 1.0]).hue(Hue::Palette(0));
    let curve = Series::line("filter", &x, &[-2.0, 2.0, 0.0]).hue(Hue::Palette(0));
    let figure = |panel: Panel| Figure::new("").panel(panel.series(curve.clone()).area(band.clone()));
    let svg = static_figure::svg(&figure(panel())).unwrap();
    let drawn = |svg: &str| -> Vec<String> {
        let areas = svg.split("<path ").filter(|path| path.contains("fill=\"#0072b2\" fill-opacity=\"0.18\""));
        areas.map(|path| path[3..path.find('Z').unwrap()].to_owned()).collect()
    };
    // The key of the legend, and the band with twice three corners.
    let corners: Vec<usize> = drawn(&svg).iter().map(|path| path.split('L').count()).collect();
    assert_eq!(corners, [4, 6]);
    assert!(svg.contains(">filter \u{b1} 2 sigma</text>"));
    let json = interactive::plotly(&figure(panel())).unwrap();
    assert_eq!(json["data"][0]["fill"], "toself");
    // 9, 2, 1, -1, -2, -9 in steps of 0.001, each as the difference from the one before.
    let y = serde_json::json!({ "of": 0.001, "by": [9000, -7000, -1000, -2000, -1000, -7000] });
    assert_eq!(json["data"][0]["y"], y);
    assert!(json["layout"]["yaxis"]["range"][1].as_f64().unwrap() > 9.0);
    // Beyond a given range it is cut off.
    let heights = |svg: &str| -> Vec<f64> {
        drawn(svg)[1].split('L').map(|corner| corner.split(' ').next_back().unwrap().parse().unwrap()).collect()
    };
    let cut = heights(&static_figure::svg(&figure(panel().y_range(-2.0, 2.0))).unwrap());
    assert!(cut[0] == cut[1] && cut[0] < cut[2] && cut[4] == cut[5], "{cut:?}");
    static_figure::png(&figure(panel())).unwrap();
}

/// A band that is much wider than the curves are high is cut off at two of their heights beyond them.
#[test]
fn a_wide_band_does_not_flatten_the_curves() {
    let x = [0.0, 1.0, 2.0];
    let range = |half: f64, curve: [f64; 3]| {
        let band = Area::between("band", &x, &[-half, -half, -half], &[half, half, half]);
        let figure = Figure::new("").panel(panel().series(Series::line("curve", &x, &curve)).area(band));
        static_figure::png(&figure).unwrap();
        let json = interactive::plotly(&figure).unwrap();
        json["layout"]["yaxis"]["range"].as_array().unwrap().iter().map(|end| end.as_f64().unwrap()).collect::<Vec<_>>()
    };
    // From -2 to 3, and 5 % of room.
    assert_eq!(range(100.0, [0.0, 1.0, 0.5]), [-2.25, 3.25]);
    assert_eq!(range(1.5, [0.0, 1.0, 0.5]), [-1.65, 1.65]);
    // A constant curve has no height.
    assert_eq!(range(100.0, [0.5, 0.5, 0.5]), [-110.0, 110.0]);
}

/// Curves over the same abscissas have them once.
#[test]
fn abscissas_are_stored_once() {
    let [x, other] = [[0.0, 1.0, 2.0], [0.0, 1.5, 2.0]];
    let panel = [("a", x), ("b", other), ("c", x)]
        .into_iter()
        .fold(Panel::new("t", "y"), |panel, (name, x)| panel.series(Series::points(name, &x, &[0.0, 1.0, 0.5])));
    let data = interactive::plotly(&Figure::new("").panel(panel)).unwrap()["data"].take();
    assert!(data[0]["x"].is_object() && data[1]["x"].is_object());
    assert_eq!(data[2]["x"], 0);
}

/// The corner has the whole of a curve of which the axes show a part, in axes of its own within those of the panel.
#[test]
fn an_inset_has_the_whole_of_the_curves() {
    let (t, y) = ([0.0, 1.0, 2.0, 3.0], [9.0, 0.5, -0.25, 0.125]);
    let panel = Panel::new("time t (s)", "error e (m)").series(Series::line("gain", &t, &y)).y_range(-1.0, 3.0).inset();
    let plain = Panel::new("time t (s)", "error e (m)").series(Series::line("gain", &t, &y));
    let figure = Figure::new("errors").panel(plain).panel(panel);
    let json = interactive::plotly(&figure).unwrap();
    assert_eq!(json["layout"]["meta"]["insets"], serde_json::json!([["3", "2"]]));
    let range = |axis: &str, k: usize| json["layout"][axis]["range"][k].as_f64().unwrap();
    assert_eq!((range("yaxis2", 0), range("yaxis2", 1)), (-1.0, 3.0));
    // The data from -0.25 to 9 with 5 % of room.
    assert!((range("yaxis3", 0) + 0.7125).abs() < 1e-3 && (range("yaxis3", 1) - 9.4625).abs() < 1e-3, "{json}");
    for axis in ["xaxis", "yaxis"] {
        let domain = |n: &str, k: usize| json["layout"][format!("{axis}{n}")]["domain"][k].as_f64().unwrap();
        assert!(domain("2", 0) < domain("3", 0) && domain("3", 1) < domain("2", 1));
    }
    let shown: Vec<bool> = json["data"].as_array().unwrap().iter().map(|one| one["showlegend"] == true).collect();
    assert_eq!(shown, [true, false, false]);
    // In the static form the inset has a second curve.
    let strokes = |figure: &Figure| static_figure::svg(figure).unwrap().matches("<path").count();
    let without = Figure::new("errors").panel(Panel { inset: false, ..figure.panels[1].clone() });
    assert!(strokes(&Figure::new("errors").panel(figure.panels[1].clone())) > strokes(&without));
}
