//! Numbers as people read them.

/// `x` to six significant digits, without trailing zeros, in scientific notation only where it is shorter.
pub fn short(x: f64) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    if !x.is_finite() {
        return x.to_string();
    }
    let magnitude = x.abs().log10().floor();
    if (-4.0..7.0).contains(&magnitude) {
        let digits = (5.0 - magnitude).max(0.0) as usize;
        let text = format!("{x:.digits$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    } else {
        let text = format!("{x:.5e}");
        match text.split_once('e') {
            Some((mantissa, exponent)) => {
                format!("{}e{exponent}", mantissa.trim_end_matches('0').trim_end_matches('.'))
            }
            None => text,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn people_read_six_digits() {
        assert_eq!(short(0.000_136_3), "0.0001363");
        assert_eq!(short(1.0 / 3.0), "0.333333");
        assert_eq!(short(1_234_567.8), "1234568");
        assert_eq!(short(-2.5e-9), "-2.5e-9");
        assert_eq!(short(100.0), "100");
        assert_eq!(short(f64::INFINITY), "inf");
    }
}
