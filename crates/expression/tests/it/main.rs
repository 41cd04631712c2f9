mod choice;
mod expression;
mod graph;
mod plant;
mod typeset;
