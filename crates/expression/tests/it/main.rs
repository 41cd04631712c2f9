mod choice;
mod expression;
mod graph;
mod plant;
mod terms;
mod typeset;
