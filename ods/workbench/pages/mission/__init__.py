"""Parts of the observer's menu: the plan, courses over time, settings of the tracker."""
