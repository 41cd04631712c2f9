//! Setters of the fields of settings and options, with the sentence that documents each.

/// `setters! { field: Type, .. }` within an `impl` block: one setter per field. Of a field of type `Option<Type>`, the
/// setter takes the `Type`.
///
/// ```
/// #[derive(Default)]
/// pub struct Settings {
///     /// Most iterations.
///     pub iterations: usize,
///     /// Seconds, if there is a limit.
///     pub time: Option<f64>,
/// }
///
/// impl Settings {
///     luenberger_wording::setters! { iterations: usize, time: f64 }
/// }
///
/// let settings = Settings::default().iterations(7).time(0.5);
/// assert_eq!((settings.iterations, settings.time), (7, Some(0.5)));
/// ```
#[macro_export]
macro_rules! setters {
    ($($field:ident: $type:ty),+ $(,)?) => {$(
        #[doc = concat!("Sets [`", stringify!($field), "`](Self#structfield.", stringify!($field), ").")]
        #[must_use]
        pub fn $field(mut self, $field: $type) -> Self {
            self.$field = $field.into();
            self
        }
    )+};
}
