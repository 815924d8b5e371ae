"""Independent reference model of the elastic angle, made to catch mistakes of the product."""
